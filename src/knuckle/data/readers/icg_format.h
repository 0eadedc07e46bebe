// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "knuckle/core/camera.h"

namespace knuckle {

// Names and constants of the ICG set, which its reader and writer share.

/// Names that the file with the camera has in different copies of the set.
inline constexpr std::string_view kIcgCalibrationNames[] = {"calibration_depth.txt", "calib.txt"};
inline constexpr float kIcgBackgroundMetres = 1e10f;  ///< what Blender gives a ray that hits nothing

/// A depth file's name taken apart: `<stem>_depth.csv` or `<stem>_depth<number>.exr`, number as in "_0002".
struct IcgFrameName {
  std::string_view stem;    ///< "<id>_<timestamp>", with the folders before it
  std::string_view number;  ///< "_0002", or empty
  bool is_synthetic = false;
};

/// Whether a file is a depth image of the set, and which frame's.
std::optional<IcgFrameName> parse_icg_depth_name(std::string_view path);

/// The annotator of `<stem>_anno_<annotator>.txt`; empty where the name is none.
std::string_view icg_annotator_of(std::string_view path);

/// The calibration file in `folder` or the nearest folder above. Throws an Error that names `folder` where
/// none is.
std::filesystem::path find_icg_calibration(const std::filesystem::path& folder);

/// `fx fy`, `cx cy` and up to 8 distortion coefficients; in pixel-centre coordinates, whereas the file counts
/// from the pixel's corner. Width and height are not in the file and stay 0.
Camera read_icg_calibration(const std::filesystem::path& path);

/// The text of such a file, of a projective camera.
std::string icg_calibration_text(const Camera& camera);

}  // namespace knuckle
