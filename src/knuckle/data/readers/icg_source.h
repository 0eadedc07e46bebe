// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"

namespace knuckle {

/// Settings of an `icg:` source.
struct IcgOptions {
  std::string
      annotator;  ///< whose labels to take; empty: the first that is there, verified ones before others
  double background_mm = 1000;  ///< what lies farther is not a measurement, (0, inf) [mm]
  int minimum_infrared = 250;   ///< what reflects less is not a measurement, [0, 65535]

  void visit(OptionVisitor& visitor);
};

/// The set of the framework paper (Riegler et al. 2015), synthetic or recorded, in one folder or many:
/// `<id>_<timestamp>_depth_NNNN.exr` (metres) with `_rgb_NNNN.png` (red = hand), or `_depth.csv` (mm); beside
/// it
/// `_infrared.csv` and `_anno_<annotator>.txt` (20 x (u, v, d), px and mm); and the nearest
/// `calibration_depth.txt` or `calib.txt` in the folder or above. The files count pixels from the corner.
class IcgSource final : public FrameSource {
 public:
  IcgSource(std::filesystem::path folder, const IcgOptions& options);

  std::int64_t size() const override { return static_cast<std::int64_t>(depth_files_.size()); }
  Frame read(std::int64_t index) const override;
  std::optional<Convention> convention() const override;
  PixelOrigin pixel_origin() const override { return PixelOrigin::corner; }

 private:
  void choose_annotators(std::vector<std::string> found);
  void read_calibrations();
  Image<float> read_depth(const std::string& file) const;
  void add_infrared(Frame& frame) const;
  void add_mask(Frame& frame, std::string_view number) const;
  std::optional<HandPose> read_truth(const std::string& stem) const;

  std::filesystem::path folder_;
  IcgOptions options_;
  std::vector<std::string> depth_files_;                ///< relative, sorted
  std::vector<std::string> annotators_;                 ///< whose labels to look for, in this order
  std::map<std::string, Camera, std::less<>> cameras_;  ///< one per folder that holds frames; of size 0
};

}  // namespace knuckle
