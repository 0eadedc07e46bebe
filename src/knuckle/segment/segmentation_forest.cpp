// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/segmentation_forest.h"

#include <string>
#include <string_view>

#include "knuckle/core/error.h"
#include "knuckle/storage/model_file.h"

namespace knuckle {
namespace {

constexpr std::string_view kFormat = "knuckle-forest";
constexpr int kVersion = 2;
constexpr std::string_view kKind = "segmentation";

}  // namespace

void save_segmentation_forest(const std::filesystem::path& path, const PixelForest& forest) {
  ModelWriter file(kFormat, kVersion);
  file.set("kind", kKind);
  write_forest(file, forest);
  file.save(path);
}

PixelForest load_segmentation_forest(const std::filesystem::path& path) {
  return read_segmentation_forest(ModelFile::open(path));
}

PixelForest read_segmentation_forest(const ModelFile& file) {
  file.require_format(kFormat, kVersion);
  const std::string kind = file.text("kind");
  if (kind != kKind) fail("{}: a forest of kind \"{}\", expected \"{}\"", file.origin(), kind, kKind);
  return read_pixel_forest(file);
}

}  // namespace knuckle
