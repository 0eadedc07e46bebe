// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/data/frame_source.h"
#include "knuckle/eval/metrics/metrics.h"
#include "knuckle/eval/metrics/significance.h"
#include "knuckle/hand/landmark_definition.h"

namespace knuckle {

/// What a comparison of methods found out.
struct Evaluation {
  std::string truth;      ///< where the truth comes from
  Convention convention;  ///< of the truth
  std::vector<MethodScore> methods;
  /// The same methods in the landmarks that all of them and the truth share, without motion; empty where all
  /// were compared in these anyway, or nobody asked.
  std::vector<MethodScore> in_common = {};
  /// Between methods that were compared in the same landmarks: `in_common` where there is one, else
  /// `methods`.
  std::vector<MethodDifference> differences = {};
};

/// Whether all methods were compared in the same landmarks: only then can one be called the best.
bool compare_the_same(const std::vector<MethodScore>& methods);

/// Scores every method against the truth, on all threads; with `wants_common` also in the landmarks that all
/// share. Throws an Error where predictions do not fit the truth (joint_errors says when), two methods have
/// one name, there is no method, or all were to be compared in common and share no landmark.
Evaluation evaluate(const Truth& truth, const std::vector<Predictions>& methods, bool wants_common = false);

/// The camera of the option `--camera fx,fy,cx,cy` [px]; a negative fy is a y axis that points up. Its size
/// is not known and set to twice the principal point: enough to convert poses. Throws an Error that quotes a
/// faulty text.
Camera camera_from_text(std::string_view text);

/// Truth from a poses file seen by one camera. `origin`: pixel origin of the file and of the camera's
/// principal point.
Truth truth_from_file(const std::filesystem::path& path, const std::optional<Convention>& convention,
                      const Camera& camera, PixelOrigin origin = PixelOrigin::centre);

/// Truth from a source's labels; opens no image where the source can do without. `name` is the source's, for
/// messages. Throws an Error where the source has no truth.
Truth truth_from_source(const FrameSource& source, const std::string& name);

/// Moves all predictions to where a definition says that a data set's landmarks lie, but those that are in a
/// convention of the data set's own already; a truth of another convention that has all of the 22 too, so
/// that they can be scored on synthetic frames. Throws an Error where predictions lack some of the 22
/// landmarks that this is made of.
void move_landmarks(const LandmarkDefinition& definition, Truth& truth, std::vector<Predictions>& methods);

/// One `NAME=PATH` of the option `--predictions`.
struct NamedPath {
  std::string name;
  std::filesystem::path path;
};

/// Throws an Error that quotes a text without name or path.
NamedPath named_path_from_text(std::string_view text);

/// What the files of predictions are, where they do not say it themselves.
struct PredictionFormat {
  std::optional<Convention> convention = std::nullopt;
  PoseCoordinates coordinates = {};
  PixelOrigin origin = PixelOrigin::centre;  ///< that u and v count from
};

/// Reads the files of all methods, on all threads. `truth` gives the cameras that x y z need. Where numbers
/// look like another format (`likely_coordinates`), a line that says so is added to `remarks`.
std::vector<Predictions> predictions_from_files(std::span<const NamedPath> files, const Truth& truth,
                                                const PredictionFormat& format,
                                                std::vector<std::string>& remarks);
/// The same of files in u v d, of which no truth is known.
std::vector<Predictions> predictions_from_files(std::span<const NamedPath> files,
                                                const std::optional<Convention>& convention,
                                                PixelOrigin origin = PixelOrigin::centre);

}  // namespace knuckle
