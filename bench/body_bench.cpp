// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "knuckle/hand/skinning.h"
#include "knuckle/synth/makehuman/makehuman_import.h"
#include "knuckle/synth/people/body_shape.h"

namespace knuckle {
namespace {

/// Poses the sections of the mean adult: 0 hand, 1 hand and arm, 2 all.
void pose_body(benchmark::State& state) {
  if (!std::filesystem::exists(makehuman_folder() / "public")) {
    state.SkipWithError("MakeHuman's data is not on this machine (scripts/fetch_makehuman.sh)");
    return;
  }
  const Body body = import_makehuman(makehuman_folder());
  const ShapedBody person = shaped_body(body, shape_coefficients(body, PersonShape{}));
  const Eigen::Quaternionf bent(Eigen::AngleAxisf(0.1f, Eigen::Vector3f::UnitX()));
  const BodyPose pose{std::vector<Eigen::Quaternionf>(body.names.size(), bent),
                      Eigen::Isometry3f::Identity()};
  const auto vertices = static_cast<std::size_t>(body.sections.at(state.range(0)).vertices);
  for (auto _ : state) benchmark::DoNotOptimize(posed_body(person, pose, vertices));
  state.counters["vertices"] = static_cast<double>(vertices);
}
BENCHMARK(pose_body)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);

void shape_person(benchmark::State& state) {
  if (!std::filesystem::exists(makehuman_folder() / "public")) {
    state.SkipWithError("MakeHuman's data is not on this machine (scripts/fetch_makehuman.sh)");
    return;
  }
  const Body body = import_makehuman(makehuman_folder());
  PersonShape someone;
  someone.age = 0.7;
  someone.weight = 0.6;
  someone.muscle = 0.4;
  someone.height = 0.55;
  someone.hand_scale = 0.2;
  for (auto _ : state) benchmark::DoNotOptimize(shaped_body(body, shape_coefficients(body, someone)));
}
BENCHMARK(shape_person)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace knuckle
