// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/pose.h"
#include "knuckle/patch/cube_patch.h"
#include "knuckle/patch/hand_patch.h"

namespace knuckle {

/// One training sample: a cube larger than the network's, so that there is something to turn and shift into
/// view, and where the joints are in it. Lengths are the crop's pixels and halves of the crop cube's side.
struct CubeSample {
  std::span<const std::uint8_t> codes;  ///< crop_px x crop_px depths, see `depth_of_code`
  std::span<const float> joints;  ///< J x 3: u and v from the crop's centre [crop px], d [halves]; or NaN
  Point3 centre_mm;               ///< of the cube, in the camera
};

/// Training samples in memory: 8 bits per pixel, 20.7 kB for a crop of 144 x 144. A step is 1/127 of half the
/// crop's cube, 1.5 mm for one of 375 mm: less than a sensor's noise.
class CubeSamples {
 public:
  static constexpr std::uint8_t kBackgroundCode = 255;

  /// Room for `count` samples. `patch` is what the network sees, `crop_px` (at least its size) what is kept,
  /// at the same scale.
  CubeSamples(std::int64_t count, int joint_count, const Cube& patch, int crop_px);

  /// The cube to cut out of frames.
  Cube crop() const { return {crop_px_, patch_.side_mm * crop_px_ / patch_.size_px}; }
  const Cube& patch() const { return patch_; }
  int joint_count() const { return joint_count_; }
  int crop_px() const { return crop_px_; }
  /// Memory of so many samples [bytes].
  static std::int64_t bytes(std::int64_t count, int joint_count, int crop_px);

  /// Sets sample `index`, each at most once; safe to call from many threads. `crop` was cut out with
  /// `crop()` around `centre_mm`; `joints` are in its patch coordinates, NaN where not known. Throws an Error
  /// where a size is wrong.
  void set(std::int64_t index, const HandPatch& crop, std::span<const PatchPoint> joints,
           const Point3& centre_mm);
  /// Sets sample `index` to one that was taken from others of the same sizes.
  void set(std::int64_t index, const CubeSample& sample);
  /// Forgets the places that were never set. Call it once, after the last `set`.
  void finish();

  std::int64_t size() const { return static_cast<std::int64_t>(kept_.size()); }  ///< after `finish`
  CubeSample sample(std::int64_t index) const;                                   ///< index in [0, size)

  /// Depth of a code from the cube's centre, in halves of the crop cube's side: -1 at 0, 1 at 254.
  static float depth_of_code(std::uint8_t code) { return (static_cast<float>(code) - 127.0f) / 127.0f; }

 private:
  std::size_t pixels() const { return static_cast<std::size_t>(crop_px_) * crop_px_; }  // of a crop
  std::size_t numbers() const { return 3 * static_cast<std::size_t>(joint_count_); }    // of its joints

  int joint_count_;
  Cube patch_;
  int crop_px_;
  std::vector<std::uint8_t> codes_;
  std::vector<float> joints_;
  std::vector<Point3> centres_mm_;
  std::vector<std::uint8_t> is_set_;
  std::vector<std::int64_t> kept_;
};

/// Which joints are known in at least one of the samples, joint by joint.
std::vector<bool> known_joints(const CubeSamples& samples);

}  // namespace knuckle
