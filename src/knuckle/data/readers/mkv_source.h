// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/matroska.h"

namespace knuckle {

/// Settings of an `mkv:` source.
struct MkvOptions {
  std::string camera = {};  ///< file with a [camera] table; empty: the recording's calibration

  void visit(OptionVisitor& visitor);
};

/// A recording of an Azure Kinect as `k4arecorder` writes it: a Matroska file with tracks DEPTH (millimetres)
/// and IR of 16-bit samples, and the calibration as an attachment. Colour and the motion sensor are not read.
/// Frames come in the order of their times, which count from the beginning of the recording; the infrared
/// image is that of the same time.
///
/// Opening reads no image. A block of another size is a fault of its frame.
class MkvSource final : public FrameSource {
 public:
  /// Throws an Error that names the file where it is no Matroska file that can be read, has no depth track,
  /// one of another codec or size, or no calibration.
  explicit MkvSource(std::filesystem::path path, const MkvOptions& options = {});

  std::int64_t size() const override { return static_cast<std::int64_t>(depth_.size()); }
  Frame read(std::int64_t index) const override;
  FrameLabel read_label(std::int64_t index) const override;
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  /// A track of 16-bit samples.
  struct SampleTrack {
    MatroskaTrack track;
    bool is_big_endian = false;
  };

  std::optional<SampleTrack> find_track(std::string_view name) const;
  SampleTrack require_depth_track() const;
  std::vector<MatroskaBlock> find_blocks() const;
  std::map<std::int64_t, MatroskaBlock> find_infrared() const;
  Camera find_camera(const std::string& file) const;
  std::string calibration() const;
  std::string tag(std::string_view name) const;
  Image<std::uint16_t> read_samples(const MatroskaBlock& block, bool is_big_endian,
                                    std::string_view where) const;

  Matroska file_;
  SampleTrack depth_track_;
  std::optional<SampleTrack> infrared_track_;
  std::vector<MatroskaBlock> depth_;                ///< by time
  std::map<std::int64_t, MatroskaBlock> infrared_;  ///< by time [ns]
  Camera camera_;
};

}  // namespace knuckle
