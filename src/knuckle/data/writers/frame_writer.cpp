// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/frame_writer.h"

#include <array>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/suggestion.h"
#include "knuckle/core/text.h"
#include "knuckle/data/writers/folder_writer.h"
#include "knuckle/data/writers/h5_writer.h"
#include "knuckle/data/writers/icg_writer.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 3> kFormats{"folder", "h5", "icg"};

}  // namespace

std::span<const std::string_view> frame_writer_formats() {
  return kFormats;
}

std::unique_ptr<FrameWriter> create_frame_writer(std::string_view format, const std::filesystem::path& path,
                                                 const FrameWriterOptions& options) {
  if (!(options.depth_unit_mm > 0 && options.depth_unit_mm <= 1000))
    fail("{}: depth_unit_mm = {} is not in (0, 1000]", path.string(), options.depth_unit_mm);
  if (format == "folder") return std::make_unique<FolderWriter>(path, options);
  if (format == "h5") return std::make_unique<H5Writer>(path, options);
  if (format == "icg") return std::make_unique<IcgWriter>(path, options);
  fail("unknown format '{}'{}; known are {}", format, suggestion(format, kFormats),
       joined({kFormats.begin(), kFormats.end()}));
}

}  // namespace knuckle
