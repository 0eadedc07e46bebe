// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_edit.h"

#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

using ::testing::HasSubstr;
using Kind = LabelRequest::Kind;

constexpr double kPalmMm = 95.0;

std::string edited(const LabelRequest& request, std::vector<LandmarkLabel>& labels) {
  Frame frame;
  frame.camera = testing::kLabelCamera;
  frame.depth_mm = Image<float>(frame.camera.width, frame.camera.height);
  frame.depth_mm(80, 60) = 500.0f;
  return edit_labels(request, frame, superset_convention(), kPalmMm, labels);
}

TEST(LabelEdit, PlacesMovesFreesAndVerifies) {
  std::vector<LandmarkLabel> labels(kSupersetSize);
  const auto tip = static_cast<std::size_t>(Landmark::index_tip);
  EXPECT_EQ(edited({.kind = Kind::place, .hand = {}, .landmark = tip, .u = 80, .v = 60}, labels), "");
  EXPECT_TRUE(labels[tip].is_pinned());
  EXPECT_GT(labels[tip].at.depth_mm, 500.0) << "below the skin";
  EXPECT_EQ(edited({.kind = Kind::move, .hand = {}, .landmark = 0, .point_mm = Point3(0, 0, 400)}, labels),
            "");
  EXPECT_EQ(labels[0].at.depth_mm, 400.0);
  EXPECT_EQ(edited({.kind = Kind::look, .hand = {}, .landmark = 0, .is_visible = false}, labels), "");
  EXPECT_FALSE(labels[0].is_visible);
  EXPECT_EQ(edited({.kind = Kind::free, .hand = {}, .landmark = tip}, labels), "");
  EXPECT_FALSE(labels[tip].is_pinned());
  EXPECT_EQ(edited({.kind = Kind::verify, .hand = {}}, labels), "");
  EXPECT_EQ(labels[tip].state, LabelState::verified);
  EXPECT_EQ(labels[1].state, LabelState::estimated) << "it is not labelled";
}

TEST(LabelEdit, WhatCannotBeIsSaidAndChangesNothing) {
  std::vector<LandmarkLabel> labels(kSupersetSize);
  EXPECT_THAT(edited({.kind = Kind::verify, .hand = {}}, labels), HasSubstr("nothing to verify"));
  EXPECT_THAT(edited({.kind = Kind::look, .hand = {}}, labels), HasSubstr("place it first"));
  EXPECT_THAT(edited({.kind = Kind::place, .hand = {}, .u = 10, .v = 10}, labels), HasSubstr("No depth"));
  EXPECT_THAT(edited({.kind = Kind::move, .hand = {}, .point_mm = Point3(0, 0, -1)}, labels),
              HasSubstr("behind"));
  EXPECT_EQ(labels, std::vector<LandmarkLabel>(kSupersetSize));
}

}  // namespace
}  // namespace knuckle
