// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>

#include <knuckle/core/error.h>
#include <knuckle/data/frame_source.h>

namespace own {

/// Raw depth, as a camera driver gives it: 320 x 240 floats [mm] per frame, one frame after another in a
/// file.
class RawDepthSource final : public knuckle::FrameSource {
 public:
  explicit RawDepthSource(const std::filesystem::path& path) : path_(path) {
    std::error_code missing;
    const std::uintmax_t bytes = std::filesystem::file_size(path, missing);
    if (missing) knuckle::fail("{}: there is no such file", path.string());
    if (bytes == 0 || bytes % kFrameBytes != 0)
      knuckle::fail("{}: {} bytes, expected frames of {} bytes", path.string(), bytes, kFrameBytes);
    size_ = static_cast<std::int64_t>(bytes / kFrameBytes);
  }

  std::int64_t size() const override { return size_; }

  knuckle::Frame read(std::int64_t index) const override {
    knuckle::Frame frame;
    frame.name = fmt::format("{:06}", index);
    frame.camera = kCamera;
    frame.depth_mm = knuckle::Image<float>(kCamera.width, kCamera.height);
    std::ifstream file(path_, std::ios::binary);  // one per call: many threads read at once
    file.seekg(index * static_cast<std::int64_t>(kFrameBytes));
    file.read(reinterpret_cast<char*>(frame.depth_mm.data()), kFrameBytes);
    if (!file) knuckle::fail("{}: frame {} cannot be read", path_.string(), index);
    return frame;
  }

  /// The files have no truth; a source with labels names their convention here and fills `frame.truth`.
  std::optional<knuckle::Convention> convention() const override { return std::nullopt; }

 private:
  static constexpr knuckle::Camera kCamera{
      .width = 320, .height = 240, .fx = 224, .fy = 224, .cx = 159.5, .cy = 119.5};
  static constexpr std::size_t kFrameBytes = std::size_t{320} * 240 * sizeof(float);

  std::filesystem::path path_;
  std::int64_t size_ = 0;
};

}  // namespace own
