// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "knuckle/core/frame.h"
#include "knuckle/core/options.h"
#include "knuckle/patch/hand_patch.h"
#include "knuckle/patch/patch_statistics.h"
#include "knuckle/segment/segmenter.h"

namespace knuckle {

/// How patches are made.
struct PatchOptions {
  int size_px = 96;           ///< Width and height p, [2, 1024] [px]
  std::string mode = "hand";  ///< hand: the segmented hand alone, fitted to the patch | cube: extract_cube
  double cube_mm = 250.0;     ///< Side of the cube (mode "cube"), [10, 2000] [mm]

  void visit(OptionVisitor& visitor);
  bool is_cube() const { return mode == "cube"; }
  bool operator==(const PatchOptions&) const = default;
};

/// The value of pixels that are not hand, and the largest of those that are, in deviations: behind the hand.
inline constexpr float kPatchBackground = 3.0f;

/// Cuts the hand out of a frame and normalises it (Riegler et al. 2015, section 3, preprocessing).
///
/// The patch is a square around the box's centre whose side is the box's longer one, so the aspect is kept;
/// each of its p x p pixels is the image's nearest one. Pixels that are in the hand's mask and measured get
/// their depth, less the mean over these pixels of the patch, divided by their standard deviation, and cut to
/// [-3, 3] (a stray pixel far in front of the hand or behind it must not outweigh it); all others are
/// background, +3. Then the mean patch is subtracted and the whitening applied, where the statistics hold
/// them.
///
/// In the mode "cube" a patch is what lies in a cube around the region's centre, whatever the mask says.
class PatchExtractor {
 public:
  /// A hand flatter than this is not stretched further: a sensor's noise would become its shape [mm].
  static constexpr double kSmallestDeviationMm = 1.0;

  /// Throws an Error where an option is out of range, the statistics' parts differ in size, or they are of
  /// another size than the options say.
  explicit PatchExtractor(const PatchOptions& options);
  PatchExtractor(const PatchOptions& options, PatchStatistics statistics);

  /// Nothing where no measured pixel of the hand falls on the patch. Throws an Error where the box's and the
  /// mask's sizes differ. The box may reach out of the image: background there. Safe to call from many
  /// threads.
  std::optional<HandPatch> extract(const Frame& frame, const HandRegion& hand) const;

  /// A patch around another centre than the region's: for a second look (mode "cube" only, else an Error).
  std::optional<HandPatch> extract_around(const Frame& frame, const ImagePoint& centre) const;

  const PatchOptions& options() const { return options_; }
  const PatchStatistics& statistics() const { return statistics_; }

 private:
  PatchOptions options_;
  PatchStatistics statistics_;
};

/// Where the patch of that size lies that shows this box; the depths are left at mean 0 and deviation 1.
PatchGeometry patch_geometry(const Box& box, int size_px);

}  // namespace knuckle
