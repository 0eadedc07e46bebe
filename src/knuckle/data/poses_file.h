// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// The poses of one hand, one per frame of a sequence.
struct PoseSequence {
  std::string origin;           ///< where they come from (a file, a source), for messages
  Convention convention;        ///< of every pose
  std::vector<HandPose> poses;  ///< pixel-centre coordinates; a frame without a hand: all joints missing
};

/// Reads a poses file: one line per frame, J x `u v d` (px, px, mm), `nan` where a value is not known; a
/// first line
/// `# convention: NAME` names the landmarks (other lines with # may stand around it). A file without that
/// line takes `convention`. Extra blanks, trailing separators and empty lines at the end do no harm; commas
/// count as blanks. `origin` is the pixel origin that the file's numbers count from; they are converted to
/// the library's. Throws an Error that names file and line where a line has too few or too many values, or
/// one that is not a number.
PoseSequence read_poses_file(const std::filesystem::path& path,
                             const std::optional<Convention>& convention = std::nullopt,
                             PixelOrigin origin = PixelOrigin::centre);

/// What a poses file begins with: the line `# convention: NAME`.
std::string poses_head(const Convention& convention);
/// The line of a pose in a poses file, with its end: four decimals (0.1 um), three `nan` for a joint that
/// misses one value.
std::string pose_line(const HandPose& pose, PixelOrigin origin = PixelOrigin::centre);

/// Writes a poses file with four decimals (0.1 um). A joint that misses one value is written as three `nan`.
/// Throws where a pose is of another convention; the file appears only when whole.
void write_poses_file(const std::filesystem::path& path, const Convention& convention,
                      std::span<const HandPose> poses, PixelOrigin origin = PixelOrigin::centre);

}  // namespace knuckle
