// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/evaluation.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/text.h"
#include "knuckle/data/defined_pose.h"
#include "knuckle/eval/metrics/coordinate_check.h"

namespace knuckle {
namespace {

void check_names(const std::vector<Predictions>& methods) {
  if (methods.empty()) fail("nothing to evaluate: expected at least one method's predictions");
  std::set<std::string_view> names;
  for (const Predictions& method : methods) {
    if (!names.insert(method.name).second) fail("{}: two methods have this name", method.name);
  }
}

/// Keeps a single projection where all frames have the same camera.
void merge_equal_projections(std::vector<Projection>& projections) {
  const auto is_first = [&](const Projection& projection) {
    return projection.camera() == projections.front().camera();
  };
  if (std::ranges::all_of(projections, is_first))
    projections.erase(projections.begin() + 1, projections.end());
}

/// The truth's landmarks that every method predicts.
std::vector<Landmark> common_landmarks(const Truth& truth, const std::vector<Predictions>& methods) {
  std::vector<Landmark> common;
  for (const Landmark landmark : truth.sequence.convention.landmarks) {
    const auto holds = [&](const Predictions& method) {
      return method.sequence.convention.index_of(landmark) >= 0;
    };
    if (std::ranges::all_of(methods, holds)) common.push_back(landmark);
  }
  if (common.empty()) fail("--common: no landmark is in the truth and in all predictions");
  return common;
}

std::vector<MethodScore> scored_in_common(const Truth& truth, const std::vector<Predictions>& methods) {
  const std::vector<Landmark> common = common_landmarks(truth, methods);
  std::vector<MethodScore> scores(methods.size());
  parallel_for(static_cast<std::int64_t>(methods.size()), [&](std::int64_t i) {
    scores[static_cast<std::size_t>(i)] = score(joint_errors(truth, methods[i], common), methods[i].name);
  });
  return scores;
}

/// `truth` tells cameras and sides of the frames.
void move_sequence(const LandmarkDefinition& definition, const Truth& truth, PoseSequence& sequence) {
  sequence.convention = definition.convention;
  for (std::size_t i = 0; i < sequence.poses.size(); ++i) {
    const auto frame = static_cast<std::int64_t>(i);
    HandPose& pose = sequence.poses[i];
    pose = defined_pose(definition, pose, truth.projection(frame), truth.side(frame));
  }
}

int size_around(double principal_point) {
  constexpr double kLargestSize = 1e6;  // [px]
  return static_cast<int>(std::clamp(std::ceil(2.0 * principal_point), 1.0, kLargestSize));
}

}  // namespace

bool compare_the_same(const std::vector<MethodScore>& methods) {
  return std::ranges::all_of(methods, [&](const MethodScore& method) {
    return std::ranges::equal(method.joints, methods.front().joints, {}, &JointScore::landmark,
                              &JointScore::landmark);
  });
}

Evaluation evaluate(const Truth& truth, const std::vector<Predictions>& methods, bool wants_common) {
  check_names(methods);
  Evaluation evaluation{truth.sequence.origin, truth.sequence.convention, {}};
  evaluation.methods.resize(methods.size());
  parallel_for(static_cast<std::int64_t>(methods.size()), [&](std::int64_t i) {
    MethodScore& scored = evaluation.methods[static_cast<std::size_t>(i)];
    scored = score(joint_errors(truth, methods[i]), methods[i].name);
    scored.motion = motion_score(truth, methods[i]);
  });
  if (compare_the_same(evaluation.methods)) {
    evaluation.differences = differences(evaluation.methods);
  } else if (wants_common) {
    evaluation.in_common = scored_in_common(truth, methods);
    evaluation.differences = differences(evaluation.in_common);
  }
  return evaluation;
}

Camera camera_from_text(std::string_view text) {
  const std::string where = fmt::format("camera '{}'", text);
  const std::vector<double> values = parse_numbers(text, where);
  if (values.size() != 4) fail("{}: expected fx,fy,cx,cy, found {} values", where, values.size());
  for (const double value : values) {
    if (!std::isfinite(value)) fail("{}: expected finite numbers", where);
  }
  Camera camera;
  camera.fx = values[0];
  camera.fy = values[1];
  camera.cx = values[2];
  camera.cy = values[3];
  camera.width = size_around(camera.cx);
  camera.height = size_around(camera.cy);
  try {
    check(camera);
  } catch (const Error& error) {
    fail("{}: {}", where, error.what());
  }
  return camera;
}

Truth truth_from_file(const std::filesystem::path& path, const std::optional<Convention>& convention,
                      const Camera& camera, PixelOrigin origin) {
  const Projection projection(with_pixel_origin(camera, origin, PixelOrigin::centre));
  return {read_poses_file(path, convention, origin), {projection}};
}

Truth truth_from_source(const FrameSource& source, const std::string& name) {
  const std::optional<Convention> convention = source.convention();
  if (!convention) fail("{}: this source has no truth to compare with", name);
  std::vector<FrameLabel> labels(static_cast<std::size_t>(source.size()));
  parallel_for(source.size(), [&](std::int64_t i) { labels[i] = source.read_label(i); });
  Truth truth{{name, *convention, {}}, {}};
  for (FrameLabel& label : labels) {
    truth.sequence.poses.push_back(label.truth ? std::move(*label.truth) : HandPose::missing(*convention));
    truth.projections.emplace_back(label.camera);
    truth.sides.push_back(label.side);
    truth.sequences.push_back(label.sequence);
  }
  merge_equal_projections(truth.projections);
  return truth;
}

void move_landmarks(const LandmarkDefinition& definition, Truth& truth, std::vector<Predictions>& methods) {
  const auto has_all = [](const Convention& convention) {
    return map_convention(convention, superset_convention()).missing.empty();
  };
  for (Predictions& method : methods) {
    // Who predicts a data set's own landmarks has nothing to be moved.
    if (method.sequence.convention == definition.convention && !has_all(definition.convention)) continue;
    require_all_landmarks(method.sequence.convention, method.sequence.origin);
    if (method.sequence.poses.size() != truth.sequence.poses.size()) continue;  // which the evaluation says
    move_sequence(definition, truth, method.sequence);
  }
  const Convention& labelled = truth.sequence.convention;
  if (has_all(labelled) && labelled != definition.convention)
    move_sequence(definition, truth, truth.sequence);
}

NamedPath named_path_from_text(std::string_view text) {
  const std::size_t end = text.find('=');
  if (end == std::string_view::npos || end == 0 || end + 1 == text.size()) {
    fail("predictions '{}': expected NAME=PATH", text);
  }
  return {std::string(text.substr(0, end)), std::filesystem::path(text.substr(end + 1))};
}

std::vector<Predictions> predictions_from_files(std::span<const NamedPath> files, const Truth& truth,
                                                const PredictionFormat& format,
                                                std::vector<std::string>& remarks) {
  std::vector<Predictions> methods(files.size());
  std::vector<std::optional<LikelyCoordinates>> likely(files.size());
  parallel_for(static_cast<std::int64_t>(files.size()), [&](std::int64_t i) {
    const PoseNumbers numbers = read_pose_numbers(files[i].path, format.convention, format.coordinates);
    methods[i] = {files[i].name, poses_from(numbers, truth.projections, format.origin)};
    likely[i] = likely_coordinates(truth, numbers, format.origin);
  });
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!likely[i]) continue;
    const double as_read_mm = likely[i]->median_as_read_mm;
    const std::string off =
        std::isfinite(as_read_mm) ? fmt::format("more than {:.0f} mm off", as_read_mm) : "behind the camera";
    remarks.push_back(fmt::format("{}: read so, half of its joints are {}; with {} more than {:.1f} mm off",
                                  files[i].path.string(), off, as_options(likely[i]->coordinates),
                                  likely[i]->median_mm));
  }
  return methods;
}

std::vector<Predictions> predictions_from_files(std::span<const NamedPath> files,
                                                const std::optional<Convention>& convention,
                                                PixelOrigin origin) {
  std::vector<Predictions> methods(files.size());
  parallel_for(static_cast<std::int64_t>(files.size()), [&](std::int64_t i) {
    methods[i] = {files[i].name, read_poses_file(files[i].path, convention, origin)};
  });
  return methods;
}

}  // namespace knuckle
