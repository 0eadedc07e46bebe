// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/fakenect_index.h"
#include "knuckle/data/readers/kinect_depth.h"

namespace knuckle {

/// Settings of a `fakenect:` source.
struct FakenectOptions {
  std::string camera = {};     ///< file with a [camera] table; empty: kinect_camera()
  std::string depth = "auto";  ///< what the images count: auto | raw | mm

  void visit(OptionVisitor& visitor);
};

/// A recording of a first Kinect as libfreenect's `fakenect-record` writes it: a folder with INDEX.txt and a
/// file per image. Depth images are 16-bit PGM in either order of bytes, or plain numbers (`.dump`); raw or
/// in millimetres. Times are those of the Kinect's clock. Colour and accelerometer are not read.
class FakenectSource final : public FrameSource {
 public:
  /// Throws an Error that names the file where INDEX.txt is missing or wrong, where none of its first images
  /// can be read, or where these are not a Kinect's depth.
  explicit FakenectSource(std::filesystem::path folder, const FakenectOptions& options = {});

  std::int64_t size() const override { return static_cast<std::int64_t>(images_.size()); }
  Frame read(std::int64_t index) const override;
  FrameLabel read_label(std::int64_t index) const override;
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  Image<std::uint16_t> read_stored(std::int64_t index) const;
  /// The first of the first images that can be read and shows its format.
  KinectDepthFormat find_format(std::string_view unit) const;

  std::filesystem::path folder_;
  Camera camera_;
  std::vector<FakenectImage> images_;
  KinectDepthFormat format_;
};

}  // namespace knuckle
