// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_change.h"

#include <array>
#include <string_view>

#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

using ::testing::HasSubstr;

LabelChange some_change() {
  LabelChange change{.frame = 3,
                     .side = HandSide::left,
                     .revision = 7,
                     .act = LabelAct::correct,
                     .author = "an\"n\n",
                     .time = "2026-11-23T17:40:58Z",
                     .seconds = 4.2};
  change.landmarks.resize(kSupersetSize);
  change.landmarks[1] = {.at = {12.3456, -7.5, 612.0001}, .state = LabelState::verified, .is_visible = false};
  change.landmarks[21] = {.at = {0, 0, 300}, .state = LabelState::propagated};
  return change;
}

std::string refusal(const std::string& line) {
  return testing::error_of(
      [&] { (void)parse_label_change(line, testing::closing_hand_head(5), "labels.jsonl:4"); });
}

std::string with(std::string line, const std::string& from, const std::string& to) {
  const std::size_t at = line.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return line.replace(at, from.size(), to);
}

TEST(LabelNames, AreThoseOfTheFormat) {
  const std::array<std::string_view, 4> states = {"estimated", "propagated", "corrected", "verified"};
  for (std::size_t i = 0; i < states.size(); ++i) EXPECT_EQ(name_of(static_cast<LabelState>(i)), states[i]);
  const std::array<std::string_view, 9> acts = {"estimate", "propagate", "import", "correct", "look",
                                                "verify",   "undo",      "redo",   "brush"};
  for (std::size_t i = 0; i < acts.size(); ++i) EXPECT_EQ(name_of(static_cast<LabelAct>(i)), acts[i]);
}

TEST(LabelChange, ALineIsReadAsItWasWritten) {
  const LabelChange change = some_change();
  const std::string line = to_json_line(change, superset_convention());
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const LabelChange read = parse_label_change(line, testing::closing_hand_head(5));
  EXPECT_EQ(read.frame, 3);
  EXPECT_EQ(read.side, HandSide::left);
  EXPECT_EQ(read.revision, 7);
  EXPECT_EQ(read.act, LabelAct::correct);
  EXPECT_EQ(read.author, change.author);
  EXPECT_EQ(read.time, change.time);
  EXPECT_EQ(read.seconds, 4.2);
  EXPECT_EQ(read.landmarks, change.landmarks);
  EXPECT_EQ(to_json_line(read, superset_convention()), line);
}

TEST(LabelChange, HasAllLandmarksOfTheLabels) {
  EXPECT_THAT(testing::error_of([] { (void)to_json_line(some_change(), convention_from_name("icg20")); }),
              HasSubstr("a change has 22 landmarks, the labels 20"));
}

TEST(LabelChange, AHeadIsReadAsItWasWritten) {
  const LabelHead head = testing::closing_hand_head(5);
  const std::string line = to_json_line(head);
  EXPECT_TRUE(is_label_head(line));
  const LabelHead read = parse_label_head(line);
  EXPECT_EQ(read.source, head.source);
  EXPECT_EQ(read.fingerprint, head.fingerprint);
  EXPECT_EQ(read.frames, head.frames);
  EXPECT_EQ(read.convention, head.convention);
  EXPECT_EQ(read.camera, head.camera);
  EXPECT_FALSE(is_label_head(to_json_line(some_change(), superset_convention())));
}

TEST(LabelChange, NonsenseIsRefusedByLineAndKey) {
  const std::string line = to_json_line(some_change(), superset_convention());
  EXPECT_THAT(refusal("{"), HasSubstr("labels.jsonl:4: not JSON"));
  EXPECT_THAT(refusal("[[[[[[[[[[]]]]]]]]]]"), HasSubstr("nested too deeply"));
  EXPECT_THAT(refusal(with(line, "\"frame\":3", "\"frame\":5")), HasSubstr("frame: is 5, expected 0 to 4"));
  EXPECT_THAT(refusal(with(line, "\"frame\":3", "\"frame\":18446744073709551615")),
              HasSubstr("frame: is 18446744073709551615"));
  EXPECT_THAT(refusal(with(line, "\"frame\":3", "\"frame\":\"3\"")), HasSubstr("expected a whole number"));
  EXPECT_THAT(refusal(with(line, "\"left\"", "\"both\"")), HasSubstr("side: is 'both'"));
  EXPECT_THAT(refusal(with(line, "\"verified\"", "\"guessed\"")), HasSubstr("landmarks.palm: is 'guessed'"));
  EXPECT_THAT(refusal(with(line, "12.3456", "1e300")), HasSubstr("landmarks.palm: is 1e+300"));
  EXPECT_THAT(refusal(with(line, "\"palm\"", "\"plam\"")), HasSubstr("'plam' is not the next landmark"));
  const std::size_t end = line.find("}", line.find("\"landmarks\""));
  const std::size_t last = line.rfind("null,\"", end) + 4;
  EXPECT_THAT(refusal(with(line, line.substr(last, end - last), "")),
              HasSubstr("landmarks: has 21 landmarks, expected 22"));
  EXPECT_THAT(refusal(with(line, "12.3456,", "")), HasSubstr("landmarks.palm: expected null or"));
  EXPECT_THAT(refusal(with(line, "12.3456", "true")), HasSubstr("landmarks.palm: expected a number"));
  EXPECT_THAT(refusal(with(line, "4.2", "-1")), HasSubstr("seconds: is -1"));
  EXPECT_THAT(refusal(with(line, "4.2", "1e7")), HasSubstr("seconds: is 1"));
  EXPECT_THAT(refusal(with(line, "2026-11-23", std::string(300, '2'))),
              HasSubstr("bytes, expected 256 at most"));
  const std::size_t begin = line.find("\"landmarks\":{") + 12;
  EXPECT_THAT(refusal(with(line, line.substr(begin, line.find('}', begin) + 1 - begin), "[]")),
              HasSubstr("landmarks: expected an object"));
  EXPECT_THAT(refusal(with(line, ",\"act\":\"correct\"", "")), HasSubstr("lacks the key 'act'"));
  EXPECT_THAT(refusal(with(line, "\"seconds\"", "\"secs\"")), HasSubstr("unknown key 'secs'"));
  EXPECT_THAT(refusal(with(line, "\"revision\":7", "\"revision\":0")), HasSubstr("revision: is 0"));
}

TEST(LabelChange, AHeadOfAnotherVersionOrOtherLandmarksIsRefused) {
  const std::string line = to_json_line(testing::closing_hand_head(5));
  const auto refused = [](const std::string& text) {
    return testing::error_of([&] { (void)parse_label_head(text, "labels.jsonl:1"); });
  };
  EXPECT_THAT(refused(with(line, "{\"knuckle_labels\":1", "{\"knuckle_labels\":2")),
              HasSubstr("is 2, expected 1"));
  EXPECT_THAT(refused(with(line, "\"knuckle22\"", "\"icg20\"")), HasSubstr("landmarks: are not those"));
  EXPECT_THAT(refused(with(line, "\"knuckle22\"", "\"mine\"")), HasSubstr("convention"));
  EXPECT_THAT(refused(with(line, "\"frames\":5", "\"frames\":0")), HasSubstr("frames: is 0"));
  EXPECT_THAT(refused(with(line, "\"width\":160", "\"width\":99999999")), HasSubstr("width"));
  EXPECT_THAT(refused(with(line, "\"distortion\":[", "\"distortion\":[0,")),
              HasSubstr("distortion: expected a list of 8 numbers"));
  const std::size_t begin = line.find("\"landmarks\":[") + 12;
  const std::string landmarks = line.substr(begin, line.find(']', begin) + 1 - begin);
  EXPECT_THAT(refused(with(line, landmarks, "7")), HasSubstr("landmarks: expected a list of landmarks"));
  EXPECT_THAT(refused(with(line, landmarks, "[7]")), HasSubstr("landmarks: expected a text"));
}

TEST(LabelChange, NamesOfAuthorsStayWithinTheFolder) {
  for (const char* const name : {"ann", "Ann-2.b_c"}) EXPECT_TRUE(is_author_name(name)) << name;
  for (const char* const name : {"", ".", "..", ".ann", "a/b", "a b", "\xc3\xa4"})
    EXPECT_FALSE(is_author_name(name)) << name;
  EXPECT_FALSE(is_author_name(std::string(65, 'a')));
}

}  // namespace
}  // namespace knuckle
