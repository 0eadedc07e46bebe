// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/exr_image.h"

#include <exception>
#include <string>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>

#include "knuckle/core/error.h"
#include "knuckle/core/image_size.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/data/readers/exr_header.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

/// The name of the channel that holds depth.
std::string depth_channel(const Imf::ChannelList& channels, const std::string& file) {
  if (channels.begin() == channels.end()) fail("{}: has no channel", file);
  std::string name = channels.begin().name();
  for (const char* const usual : {"R", "Y", "V", "Z"})
    if (channels.findChannel(usual)) name = usual;
  if (channels[name.c_str()].type == Imf::UINT)
    fail("{}: channel {} holds whole numbers, expected float depth in metres", file, name);
  return name;
}

/// A slice over `image`, whose first pixel is pixel (x, y) of the file.
Imf::Slice slice_of(Image<float>& image, int x, int y) {
  const Imath::Box2i window({x, y}, {x + image.width() - 1, y + image.height() - 1});
  return Imf::Slice::Make(Imf::FLOAT, image.data(), window, sizeof(float), sizeof(float) * image.width());
}

bool limit_image_size() {
  Imf::Header::setMaxImageSize(limits::kImageSide, limits::kImageSide);
  Imf::Header::setMaxTileSize(limits::kImageSide, limits::kImageSide);
  return true;
}

/// Throws where a file is too small for that many pixels, however well they are compressed.
void require_room(const std::string& name, std::int64_t pixels) {
  constexpr std::int64_t kPixelsPerByte = 4096;
  const auto bytes = static_cast<std::int64_t>(std::filesystem::file_size(name));
  if (pixels / kPixelsPerByte > bytes) {
    fail("{}: says that it holds {} pixels, more than {} bytes can; it is damaged", name, pixels, bytes);
  }
}

Image<float> read_channel(const std::string& name) {
  require_regular_file(name);
  check_exr_header(name);
  // Before the library takes memory for a row of blocks by what a header says.
  [[maybe_unused]] static const bool is_limited = limit_image_size();
  Imf::InputFile file(name.c_str(), 1);
  const Imath::Box2i window = file.header().dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  require_image_size({width, height}, name);
  require_room(name, width * height);
  const std::string channel = depth_channel(file.header().channels(), name);
  Image<float> image(static_cast<int>(width), static_cast<int>(height));
  Imf::FrameBuffer buffer;
  buffer.insert(channel.c_str(), slice_of(image, window.min.x, window.min.y));
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return image;
}

void write_channel(const std::filesystem::path& path, const Image<float>& image) {
  Imf::Header header(image.width(), image.height());
  header.compression() = Imf::ZIP_COMPRESSION;
  header.channels().insert("R", Imf::Channel(Imf::FLOAT));
  Image<float> pixels = image;  // the library takes no constant memory
  Imf::FrameBuffer buffer;
  buffer.insert("R", slice_of(pixels, 0, 0));
  Imf::OutputFile file(path.c_str(), header, 1);
  file.setFrameBuffer(buffer);
  file.writePixels(image.height());
}

}  // namespace

Image<float> read_exr(const std::filesystem::path& path) {
  try {
    return read_channel(path.string());
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    fail("{}: cannot be read as an EXR image: {}", path.string(), error.what());
  }
}

void write_exr(const std::filesystem::path& path, const Image<float>& image) {
  write_file_atomically(path, [&](const std::filesystem::path& temporary) {
    try {
      write_channel(temporary, image);
    } catch (const std::exception& error) {
      fail("{}: cannot write: {}", path.string(), error.what());
    }
  });
}

}  // namespace knuckle
