// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/frame.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/options.h"

namespace knuckle {

/// The `[camera]` table of a dataset.toml, in the pixel origin of the set.
struct CameraOptions {
  std::string model = "projective";  ///< projective | orthographic
  int width = 0;                     ///< [1, 16384] [px]
  int height = 0;                    ///< [1, 16384] [px]
  double fx = 0;                     ///< [px], or px per mm for an orthographic camera; not 0
  double fy = 0;                     ///< the same down the image
  double cx = 0;                     ///< [px]
  double cy = 0;                     ///< [px]
  std::vector<double> distortion;    ///< 0 to 8 coefficients in OpenCV's order

  void visit(OptionVisitor& visitor);
};

/// The top of a dataset.toml.
struct FolderOptions {
  std::string convention;               ///< of joints.txt; empty where there is none
  double depth_unit_mm = 1.0;           ///< millimetres a count of depth, (0, 1000]
  std::string pixel_origin = "centre";  ///< centre | corner
  std::string side;  ///< which hands are seen: right | left | both; empty where it is not said
  double rate_hz =
      0.0;  ///< frames per second, (0, 10000], where there is no times.txt; 0 where it is not said

  void visit(OptionVisitor& visitor);
};

/// What a dataset.toml says.
struct FolderDescription {
  std::optional<Convention> convention;  ///< of joints.txt
  double depth_unit_mm = 1.0;
  PixelOrigin pixel_origin = PixelOrigin::centre;  ///< of the files
  Camera camera;                                   ///< in pixel-centre coordinates, whatever the files use
  std::string side;                                ///< right | left | both; empty where it is not known
  double rate_hz = 0.0;  ///< frames per second within a sequence; 0 where it is not known

  /// Which hand all frames show; nothing where they show both or it is not known.
  std::optional<HandSide> hand_side() const;
};

/// Reads a dataset.toml strictly. Throws an Error that names the file and the key at fault.
FolderDescription read_folder_description(const std::filesystem::path& path);

/// The camera of a file for sources that know none: the [camera] table of a dataset.toml, in the
/// `pixel_origin` that may stand above it; the answer counts from pixel centres. Throws as
/// `read_folder_description` does.
Camera read_camera_file(const std::filesystem::path& path);

/// The text of a dataset.toml.
std::string folder_description_as_toml(const FolderDescription& description);

}  // namespace knuckle
