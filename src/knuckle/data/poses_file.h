// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/pose.h"
#include "knuckle/data/pose_coordinates.h"

namespace knuckle {

/// The poses of one hand, one per frame of a sequence.
struct PoseSequence {
  std::string origin;           ///< where they come from (a file, a source), for messages
  Convention convention;        ///< of every pose
  std::vector<HandPose> poses;  ///< pixel-centre coordinates; a frame without a hand: all joints missing
};

/// A poses file as it stands: three numbers a joint, not converted yet.
struct PoseNumbers {
  std::string origin;     ///< where they come from, for messages
  Convention convention;  ///< of every pose
  PoseCoordinates coordinates;
  std::vector<double> values;  ///< frames x joints x 3, NaN where one is not known

  std::int64_t frames() const {
    return static_cast<std::int64_t>(values.size() / (3 * convention.landmarks.size()));
  }
};

/// Reads a poses file: one line per frame, J x `u v d` (px, px, mm), `nan` where a value is not known; a
/// first line
/// `# convention: NAME` names the landmarks (other lines with # may stand around it). A file without that
/// line takes `convention`. Lines `# format: xyz`, `# axes: x,-y,-z` and `# unit: m` say what else its
/// numbers are; a file without them takes `coordinates`. Extra blanks, trailing separators and empty lines at
/// the end do no harm; commas count as blanks. Throws an Error that names file and line where a line has too
/// few or too many values, or one that is not a number.
PoseNumbers read_pose_numbers(const std::filesystem::path& path,
                              const std::optional<Convention>& convention = std::nullopt,
                              const PoseCoordinates& coordinates = {});

/// The poses that the numbers stand for. `projections`: one per frame, or a single one for all frames; u v d
/// need none. `origin` is the pixel origin that u and v count from; they are converted to the library's.
/// Throws an Error that names the file where x y z have no camera, or another number of frames than cameras.
PoseSequence poses_from(const PoseNumbers& numbers, std::span<const Projection> projections,
                        PixelOrigin origin = PixelOrigin::centre);

/// The poses of a file in u v d.
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
