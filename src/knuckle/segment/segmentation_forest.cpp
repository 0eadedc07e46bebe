// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/segmentation_forest.h"

#include <string>
#include <string_view>

#include "knuckle/core/error.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/hdf5_file.h"

namespace knuckle {
namespace {

constexpr std::string_view kFormat = "knuckle-forest";
constexpr int kVersion = 1;
constexpr std::string_view kKind = "segmentation";

}  // namespace

void save_segmentation_forest(const std::filesystem::path& path, const PixelForest& forest) {
  write_file_atomically(path, [&](const std::filesystem::path& temporary) {
    Hdf5File file = Hdf5File::create(temporary);
    file.set_attribute("format", kFormat);
    file.set_attribute("version", double{kVersion});
    file.set_attribute("kind", kKind);
    write_forest(file, forest);
    file.close();
  });
}

PixelForest load_segmentation_forest(const std::filesystem::path& path) {
  const Hdf5File file = Hdf5File::open(path);
  file.require_format(kFormat, kVersion);
  const std::string kind = file.text_attribute("kind");
  if (kind != kKind) fail("{}: a forest of kind \"{}\", expected \"{}\"", path.string(), kind, kKind);
  return read_pixel_forest(file);
}

}  // namespace knuckle
