// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_request.h"

#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

using ::testing::HasSubstr;
using Kind = LabelRequest::Kind;

LabelRequest parsed(std::string_view text) {
  return parse_label_request(text, testing::closing_hand_head(20));
}

std::string request_refusal(const std::string& text) {
  return testing::error_of([&] { (void)parsed(text); });
}

TEST(LabelRequest, EachKindIsRead) {
  const LabelRequest place = parsed(
      R"({"act":"place","frame":12,"side":"left","revision":3,"landmark":"index_tip","pixel":[120.5,88],"seconds":2.5,"preview":true,"model":false})");
  EXPECT_EQ(place.kind, Kind::place);
  EXPECT_EQ(place.hand, (HandKey{12, HandSide::left}));
  EXPECT_EQ(place.revision, 3);
  EXPECT_EQ(superset_convention().landmarks[place.landmark], Landmark::index_tip);
  EXPECT_EQ(place.u, 120.5);
  EXPECT_EQ(place.v, 88.0);
  EXPECT_EQ(place.seconds, 2.5);
  EXPECT_TRUE(place.is_preview);
  EXPECT_FALSE(place.uses_model);
  const LabelRequest move = parsed(
      R"({"act":"move","frame":0,"side":"right","revision":0,"landmark":"wrist","point_mm":[1,-2,300]})");
  EXPECT_EQ(move.point_mm, Point3(1, -2, 300));
  EXPECT_TRUE(move.uses_model);
  EXPECT_FALSE(
      parsed(R"({"act":"look","frame":0,"side":"right","revision":1,"landmark":"wrist","visible":false})")
          .is_visible);
  EXPECT_EQ(parsed(R"({"act":"free","frame":0,"side":"right","revision":1,"landmark":"palm"})").landmark, 1U);
  EXPECT_EQ(parsed(R"({"act":"verify","frame":19,"side":"right","revision":1})").kind, Kind::verify);
  EXPECT_EQ(parsed(R"({"act":"undo"})").kind, Kind::undo);
  EXPECT_EQ(parsed(R"({"act":"redo"})").kind, Kind::redo);
}

TEST(LabelRequest, StrokesAreReadAndRefused) {
  const auto brush = [](std::string_view points, std::string_view radius, std::string_view erases) {
    return fmt::format(
        R"({{"act":"brush","frame":2,"side":"left","revision":0,"points":{},"radius_px":{},"erases":{}}})",
        points, radius, erases);
  };
  const LabelRequest request = parsed(brush("[[1,2.5],[-3,4]]", "6", "true"));
  EXPECT_EQ(request.kind, Kind::brush);
  ASSERT_EQ(request.stroke.points.size(), 2U);
  EXPECT_EQ(request.stroke.points[1][0], -3.0);
  EXPECT_EQ(request.stroke.radius_px, 6.0);
  EXPECT_TRUE(request.stroke.erases);
  EXPECT_EQ(parsed(R"({"act":"outline","frame":2,"side":"left","revision":0})").kind, Kind::outline);
  EXPECT_THAT(request_refusal(brush("[]", "6", "true")), HasSubstr("1 to 256 points"));
  EXPECT_THAT(request_refusal(brush("[[1]]", "6", "true")), HasSubstr("a list of 2 numbers"));
  EXPECT_THAT(request_refusal(brush("[[1,1e9]]", "6", "true")), HasSubstr("points: is"));
  EXPECT_THAT(request_refusal(brush("[[1,1]]", "0.2", "true")), HasSubstr("radius_px: is 0.2"));
  EXPECT_THAT(request_refusal(brush("[[1,1]]", "101", "true")), HasSubstr("radius_px: is 101"));
  EXPECT_THAT(request_refusal(brush("[[1,1]]", "6", "1")), HasSubstr("true or false"));
  std::string many = "[[1,1]";
  for (int i = 0; i < 256; ++i) many += ",[1,1]";
  EXPECT_THAT(request_refusal(brush(many + "]", "6", "true")), HasSubstr("1 to 256 points"));
}

TEST(LabelRequest, EverythingElseIsRefused) {
  EXPECT_THAT(request_refusal(""), HasSubstr("not JSON"));
  EXPECT_THAT(request_refusal("[]"), HasSubstr("expected an object"));
  EXPECT_THAT(request_refusal(std::string(9000, ' ')), HasSubstr("9000 bytes, expected 8192"));
  EXPECT_THAT(request_refusal(std::string(500, '[')), HasSubstr("nested too deeply"));
  EXPECT_THAT(request_refusal(R"({"act":"erase"})"), HasSubstr("act: is 'erase'"));
  EXPECT_THAT(request_refusal(R"({"act":"verify"})"), HasSubstr("lacks the key 'frame'"));
  EXPECT_THAT(request_refusal(R"({"act":"undo","frame":1})"), HasSubstr("unknown key 'frame'"));
  EXPECT_THAT(request_refusal(R"({"act":"verify","frame":20,"side":"right","revision":1})"),
              HasSubstr("frame: is 20, expected 0 to 19"));
  EXPECT_THAT(request_refusal(R"({"act":"verify","frame":-1,"side":"right","revision":1})"),
              HasSubstr("frame: is -1"));
  EXPECT_THAT(request_refusal(R"({"act":"verify","frame":1.5,"side":"right","revision":1})"),
              HasSubstr("whole number"));
  EXPECT_THAT(request_refusal(R"({"act":"free","frame":0,"side":"right","revision":1,"landmark":"nose"})"),
              HasSubstr("'nose' is no landmark"));
  EXPECT_THAT(request_refusal(
                  R"({"act":"place","frame":0,"side":"right","revision":1,"landmark":"palm","pixel":[1]})"),
              HasSubstr("a list of 2 numbers"));
  EXPECT_THAT(
      request_refusal(
          R"({"act":"place","frame":0,"side":"right","revision":1,"landmark":"palm","pixel":[1,1e9]})"),
      HasSubstr("pixel: is"));
  EXPECT_THAT(
      request_refusal(
          R"({"act":"move","frame":0,"side":"right","revision":1,"landmark":"palm","point_mm":[1,2,null]})"),
      HasSubstr("expected a number"));
  EXPECT_THAT(request_refusal(R"({"act":"verify","frame":0,"side":"right","revision":1,"seconds":-1})"),
              HasSubstr("seconds"));
}

}  // namespace
}  // namespace knuckle
