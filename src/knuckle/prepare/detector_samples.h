// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/segment/camera_cache.h"
#include "knuckle/segment/detector/detector_view.h"

namespace knuckle {

/// A hand of a frame, as a detector learns it.
struct HandToDetect {
  Point3 centre = Point3::Zero();  ///< the mean of its known landmarks, in camera coordinates [mm]
  double extent_mm = 0.0;          ///< from there to the farthest one
  std::optional<HandSide> side;    ///< nothing: not known
  bool counts = true;              ///< false: too little of it is seen to ask for it, or to call it wrong
};

/// The hands of a frame that are known: `Frame::hands`, or that of `Frame::truth` where those are not known.
/// Of which nearly all is hidden by something else, a hand does not count.
std::vector<HandToDetect> hands_to_detect(const Frame& frame);

// Numbers that a hand is learned from. All are of the network's small picture.
inline constexpr std::size_t kHandU = 0;             ///< of the centre [cells]
inline constexpr std::size_t kHandV = 1;             ///< the same down the picture
inline constexpr std::size_t kHandInverseDepth = 2;  ///< logarithm of the centre's inverse depth [1/m]
inline constexpr std::size_t kHandExtent = 3;        ///< logarithm of the extent over kExtentUnitMm
inline constexpr std::size_t kHandSide = 4;          ///< 1 right, 0 left, NaN not known
/// 1, or 0 where the hand neither has to be found nor is wrong; NaN: there is no such hand.
inline constexpr std::size_t kHandCounts = 5;
inline constexpr std::size_t kHandNumbers = 6;        ///< how many there are of a hand
inline constexpr std::size_t kMostLabelledHands = 4;  ///< of a frame; what is more is not learned
using LabelledHands = std::array<float, kMostLabelledHands * kHandNumbers>;

/// One sample: a frame, small, and its hands.
struct DetectorSample {
  std::span<const std::uint16_t> codes;    ///< height x width, see `inverse_depth_of_code`
  std::span<const std::uint8_t> measured;  ///< of the nine places of each cell
  std::span<const float> hands;            ///< kMostLabelledHands x kHandNumbers
};

/// Samples in memory, three bytes per cell: 37 kB for 128 x 96.
class DetectorSamples {
 public:
  DetectorSamples(const DetectorOptions& options, std::int64_t count);

  const DetectorOptions& options() const { return options_; }
  std::int64_t size() const { return count_; }
  /// Memory of so many samples [bytes].
  static std::int64_t bytes(std::int64_t count, const DetectorOptions& options);

  /// Sets sample `index`; safe to call from many threads for different ones.
  void set(std::int64_t index, const DetectorInput& input, const LabelledHands& hands);
  DetectorSample sample(std::int64_t index) const;  ///< index in [0, size)

  static float inverse_depth_of_code(std::uint16_t code) { return static_cast<float>(code) / kCodesPerUnit; }
  static float share_of(std::uint8_t measured) { return static_cast<float>(measured) / kPlaces; }

 private:
  static constexpr float kCodesPerUnit = 6500.0f;  // a step is 0.15 mm at 1 m
  static constexpr float kPlaces = 9.0f;

  std::size_t cells() const { return static_cast<std::size_t>(options_.width) * options_.height; }

  DetectorOptions options_;
  std::int64_t count_;
  std::vector<std::uint16_t> codes_;
  std::vector<std::uint8_t> measured_;
  std::vector<float> hands_;
};

/// The numbers of a frame's hands in a view of its camera.
LabelledHands hand_numbers(const std::vector<HandToDetect>& hands, const DetectorView& view);

/// A set of frames that a detector learns from.
struct DetectorSource {
  std::string source = {};  ///< as `open_source` takes it
  int most = 0;             ///< Frames used at most, evenly spread, [0, 1e9]; 0: all

  void visit(OptionVisitor& visitor);
};

/// Frames of one or more sources, one after another, as samples, read and shrunk each time that they are
/// asked for. Frames without a hand are samples too. Safe to be used by many threads at once.
class DetectorFrames {
 public:
  /// Throws an Error where a source has no truth.
  DetectorFrames(std::span<const DetectorSource> sources, const DetectorOptions& options);

  const DetectorOptions& options() const { return options_; }
  std::int64_t size() const { return count_; }
  /// Sets sample `place` of `to` to the one of this number, in [0, size). Throws an Error where its frame
  /// cannot be read.
  void put(std::int64_t number, DetectorSamples& to, std::int64_t place) const;

 private:
  /// The samples of a source, the first of which has the number `first`.
  struct Part {
    std::unique_ptr<const FrameSource> source;
    std::int64_t first;
    std::int64_t count;
  };

  std::vector<Part> parts_;
  DetectorOptions options_;
  std::int64_t count_ = 0;
  mutable CameraCache<DetectorView> views_;
};

/// All samples of these frames in memory, on all threads.
DetectorSamples samples_of(const DetectorFrames& frames);

}  // namespace knuckle
