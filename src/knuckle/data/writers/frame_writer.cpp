// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/frame_writer.h"

#include <array>
#include <string_view>

#include "knuckle/core/error.h"
#include "knuckle/core/named_table.h"
#include "knuckle/data/writers/folder_writer.h"
#include "knuckle/data/writers/h5_writer.h"
#include "knuckle/data/writers/icg_writer.h"

namespace knuckle {
namespace {

template <class Writer>
std::unique_ptr<FrameWriter> create(const std::filesystem::path& path, const FrameWriterOptions& options) {
  return std::make_unique<Writer>(path, options);
}

struct WriterFormat {
  std::string_view name;
  std::unique_ptr<FrameWriter> (*create)(const std::filesystem::path& path,
                                         const FrameWriterOptions& options);
};

constexpr std::array kFormats{
    WriterFormat{"folder", create<FolderWriter>},
    WriterFormat{"h5", create<H5Writer>},
    WriterFormat{"icg", create<IcgWriter>},
};
constexpr auto kFormatNames = names_of(kFormats);

}  // namespace

std::span<const std::string_view> frame_writer_formats() {
  return kFormatNames;
}

std::unique_ptr<FrameWriter> create_frame_writer(std::string_view format, const std::filesystem::path& path,
                                                 const FrameWriterOptions& options) {
  if (!(options.depth_unit_mm > 0 && options.depth_unit_mm <= 1000))
    fail("{}: depth_unit_mm = {} is not in (0, 1000]", path.string(), options.depth_unit_mm);
  const WriterFormat* const writer = row_named(kFormats, format);
  if (writer == nullptr) fail("{}", unknown_name("format", format, kFormatNames));
  return writer->create(path, options);
}

}  // namespace knuckle
