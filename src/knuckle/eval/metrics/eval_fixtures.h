// SPDX-License-Identifier: Apache-2.0
// What the tests of this module share; not part of the library.
#pragma once

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/eval/metrics/evaluation.h"

namespace knuckle::testing {

/// That of the poses which tests make up.
inline const Convention& example_convention() {
  return convention_from_name("icg20");
}

/// Truth of `frames` icg20 poses whose joints lie on a grid around the middle of a 64 x 48 image.
inline Truth example_truth(int frames) {
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = camera.fy = 60.0;
  camera.cx = 32.0;
  camera.cy = 24.0;
  const Convention convention = convention_from_name("icg20");
  Truth truth{{"truth", convention, {}}, {Projection(camera)}};
  for (int frame = 0; frame < frames; ++frame) {
    HandPose pose = HandPose::missing(convention);
    for (int j = 0; j < convention.size(); ++j) {
      const int row = j / 5;
      pose.joints[j] = {22.0 + 4.0 * (j % 5) + 0.1 * frame, 16.0 + 4.0 * row, 500.0 + j};
    }
    truth.sequence.poses.push_back(pose);
  }
  return truth;
}

/// The true poses with noise of `deviation_mm` in depth.
inline Predictions example_predictions(const Truth& truth, const std::string& name, double deviation_mm) {
  Predictions predictions{name, truth.sequence};
  predictions.sequence.origin = name + ".txt";
  Random random(11);
  for (HandPose& pose : predictions.sequence.poses) {
    for (ImagePoint& joint : pose.joints) joint.depth_mm += deviation_mm * random.normal();
  }
  return predictions;
}

/// A source of flat depth images, with or without truth.
class FakeSource final : public FrameSource {
 public:
  FakeSource() : truth_(example_truth(4)), has_truth_(false) {}
  explicit FakeSource(Truth truth) : truth_(std::move(truth)), has_truth_(true) {}

  std::int64_t size() const override { return static_cast<std::int64_t>(truth_.sequence.poses.size()); }
  Frame read(std::int64_t index) const override {
    Frame frame;
    frame.name = "frame" + std::to_string(index);
    frame.camera = truth_.projections[0].camera();
    frame.depth_mm = Image<float>(frame.camera.width, frame.camera.height, 510.0f);
    if (has_truth_) frame.truth = truth_.sequence.poses[index];
    return frame;
  }
  std::optional<Convention> convention() const override {
    if (!has_truth_) return std::nullopt;
    return truth_.sequence.convention;
  }

 private:
  Truth truth_;
  bool has_truth_;
};

/// Whether `text` is one XML element with proper nesting, quoted attributes and escaped text. Enough for what
/// gnuplot and we write; no substitute for a validating parser.
inline bool is_well_formed_xml(std::string_view text) {
  std::vector<std::string> open;
  bool has_root = false;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == '&' && (text.find(';', i) == std::string_view::npos || text.find(';', i) > i + 8))
      return false;
    if (text[i] != '<') {
      ++i;
      continue;
    }
    std::size_t end = i + 1;
    for (char quote = 0; end < text.size() && (quote != 0 || text[end] != '>'); ++end) {
      if (quote != 0) {
        if (text[end] == '<') return false;
        if (text[end] == quote) quote = 0;
      } else if (text[end] == '"' || text[end] == '\'') {
        quote = text[end];
      }
    }
    if (end == text.size()) return false;
    const std::string_view tag = text.substr(i + 1, end - i - 1);
    i = end + 1;
    if (tag.starts_with('?') || tag.starts_with('!')) continue;
    const bool closes = tag.starts_with('/');
    const std::string name(tag.substr(closes ? 1 : 0, tag.find_first_of(" \t\r\n/", 1) - (closes ? 1 : 0)));
    if (closes) {
      if (open.empty() || open.back() != std::string(tag.substr(1))) return false;
      open.pop_back();
      continue;
    }
    if (open.empty() && has_root) return false;
    has_root = true;
    if (!tag.ends_with('/')) open.push_back(name);
  }
  return has_root && open.empty();
}

}  // namespace knuckle::testing
