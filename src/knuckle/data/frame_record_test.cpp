// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/frame_record.h"

#include <algorithm>
#include <limits>

#include <nlohmann/json.hpp>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/testing_json_schema.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Not;

const Camera kCamera{CameraModel::projective, 320, 240, 224.0, 224.0, 159.5, 119.5, {}};

HandPose random_pose(const Convention& convention, Random& random) {
  HandPose pose = HandPose::missing(convention);
  for (ImagePoint& joint : pose.joints) {
    if (random.below(5) == 0) continue;
    joint = {random.uniform(-20.0, 340.0), random.uniform(-20.0, 260.0), random.uniform(200.0, 900.0)};
  }
  for (std::size_t i = 0; i < pose.joints.size(); ++i)
    pose.confidence.push_back(static_cast<float>(random.uniform()));
  return pose;
}

/// A record in which all that may be missing is missing now and then.
FrameRecord random_record(std::uint64_t seed) {
  Random random(seed);
  FrameRecord record;
  record.frame = random.below(100000);
  record.name = "subject \"1\"\\\n/00012\xC3\xA9";
  if (random.below(2) == 0) record.time_s = random.uniform(-1.0, 2e9);
  if (random.below(4) == 0) record.latency_ms = random.uniform(0.0, 50.0);
  const std::uint32_t hands = random.below(3);
  if (hands == 0) record.status = "no hand: nothing is near";
  for (std::uint32_t i = 0; i < hands; ++i) {
    const Convention& convention =
        conventions()[random.below(static_cast<std::uint32_t>(conventions().size()))];
    HandRecord hand = hand_record(random_pose(convention, random), Projection(kCamera), PixelOrigin::corner);
    hand.id = static_cast<int>(i) + 1;
    hand.score = random.uniform();
    if (random.below(3) > 0) hand.side = random.below(2) == 0 ? HandSide::left : HandSide::right;
    if (random.below(3) == 0) hand.confidence.clear();
    if (random.below(2) == 0) {
      hand.angles_rad = {{"index_pip", random.uniform(-1.0, 1.0)}, {"index_dip", 0.0}};
      hand.skeleton = "adult";
    }
    record.hands.push_back(hand);
  }
  return record;
}

FrameRecord record_with_hands() {
  for (std::uint64_t seed = 0;; ++seed) {
    FrameRecord record = random_record(seed);
    if (record.hands.size() == 2) return record;
  }
}

testing::JsonSchema schema() {
  return testing::JsonSchema(nlohmann::json::parse(read_text_file("schemas/frame_record.json")));
}

TEST(FrameRecord, ALineReadsBackAsTheSameLine) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const std::string line = to_json_line(random_record(seed));
    EXPECT_EQ(line.find('\n'), std::string::npos);
    EXPECT_EQ(to_json_line(parse_frame_record(line)), line);
  }
}

TEST(FrameRecord, KeepsWhatItSays) {
  const FrameRecord written = record_with_hands();
  const FrameRecord read = parse_frame_record(to_json_line(written));
  EXPECT_EQ(read.frame, written.frame);
  EXPECT_EQ(read.name, written.name);
  EXPECT_EQ(read.status, written.status);
  ASSERT_EQ(read.time_s.has_value(), written.time_s.has_value());
  ASSERT_EQ(read.hands.size(), written.hands.size());
  for (std::size_t i = 0; i < read.hands.size(); ++i) {
    const HandRecord& a = read.hands[i];
    const HandRecord& b = written.hands[i];
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.side, b.side);
    EXPECT_EQ(a.convention, b.convention);
    EXPECT_EQ(a.skeleton, b.skeleton);
    EXPECT_NEAR(a.score, b.score, 0.5e-4);
    for (std::size_t j = 0; j < b.landmarks_mm.size(); ++j) {
      ASSERT_EQ(a.landmarks_mm[j].allFinite(), b.landmarks_mm[j].allFinite());
      if (!b.landmarks_mm[j].allFinite()) continue;
      EXPECT_NEAR((a.landmarks_mm[j] - b.landmarks_mm[j]).norm(), 0.0, 1e-3);
      EXPECT_NEAR(a.landmarks_px[j].u, b.landmarks_px[j].u, 0.5e-3 + 1e-9);
    }
  }
}

TEST(FrameRecord, IsTheSchemas) {
  const testing::JsonSchema rules = schema();
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    EXPECT_EQ(rules.fault(nlohmann::json::parse(to_json_line(random_record(seed)))), "") << "seed " << seed;
}

TEST(FrameRecord, TheSchemaRefusesWhatIsNoRecord) {
  const testing::JsonSchema rules = schema();
  const nlohmann::json good = nlohmann::json::parse(to_json_line(record_with_hands()));
  ASSERT_FALSE(good.at("hands").empty());
  const auto fault_after = [&](const auto& spoil) {
    nlohmann::json record = good;
    spoil(record);
    return rules.fault(record);
  };
  EXPECT_EQ(fault_after([](auto& record) { record.erase("status"); }), ": lacks \"status\"");
  EXPECT_EQ(fault_after([](auto& record) { record["colour"] = 1; }), "/colour: is not allowed");
  EXPECT_THAT(fault_after([](auto& record) { record["frame"] = -1; }), HasSubstr("/frame: is below"));
  EXPECT_THAT(fault_after([](auto& record) { record["frame"] = 1.5; }),
              HasSubstr("/frame: is not of the type"));
  EXPECT_THAT(fault_after([](auto& record) { record["hands"][0]["side"] = "up"; }),
              HasSubstr("/hands/0/side"));
  EXPECT_THAT(fault_after([](auto& record) { record["hands"][0]["landmarks_mm"]["elbow"] = nullptr; }),
              HasSubstr("/hands/0/landmarks_mm/elbow: is not one of"));
  EXPECT_THAT(fault_after([](auto& record) {
                record["hands"][0]["landmarks_px"].front() = {1, 2, 3};
              }),
              HasSubstr("is too long"));
}

TEST(FrameRecord, TheSchemaKnowsEveryLandmark) {
  const auto names =
      nlohmann::json::parse(read_text_file("schemas/frame_record.json"))["$defs"]["landmark"]["enum"];
  for (const Convention& convention : conventions()) {
    for (const Landmark landmark : convention.landmarks)
      EXPECT_EQ(std::ranges::count(names, name_of(landmark)), 1) << name_of(landmark);
  }
}

TEST(FrameRecord, HasTheKeysOfTheDocumentsInTheirOrder) {
  FrameRecord record{12, "000012", 0.4, "", {}, {}};
  EXPECT_EQ(to_json_line(record), R"({"frame":12,"name":"000012","time_s":0.400000,"status":"","hands":[]})");
  record.hands.push_back(
      hand_record(HandPose::missing(convention_from_name("nyu14")), Projection(kCamera), {}));
  record.hands[0].landmarks_mm[0] = {-0.0001, 2.0, 412.3456};
  record.hands[0].landmarks_px[0] = {1.0, 2.5};
  record.hands[0].side = HandSide::right;
  record.hands[0].score = 0.71;
  const std::string line = to_json_line(record);
  EXPECT_THAT(line,
              HasSubstr(R"("hands":[{"id":1,"side":"right","score":0.7100,"landmarks_mm":{"little_tip":)"
                        R"([0.000,2.000,412.346],"nyu_little_base":null,)"));
  EXPECT_THAT(line, HasSubstr(R"("landmarks_px":{"little_tip":[1.000,2.500],"nyu_little_base":null,)"));
  EXPECT_THAT(line, HasSubstr(R"(,"confidence":{}}]})"));
}

TEST(FrameRecord, NeverHoldsWhatJsonLacks) {
  const double infinity = std::numeric_limits<double>::infinity();
  FrameRecord record = record_with_hands();
  record.time_s = kNaN;
  record.hands[0].score = infinity;
  record.hands[0].landmarks_mm[0] = {1.0, -infinity, 2.0};
  record.hands[0].confidence.assign(record.hands[0].landmarks_mm.size(), kNaN);
  record.hands[0].angles_rad = {{"index_pip", kNaN}};
  record.status = "bytes \xFF that are no UTF-8";
  const std::string line = to_json_line(record);
  EXPECT_THAT(line, AllOf(Not(HasSubstr("nan")), Not(HasSubstr("inf"))));
  EXPECT_EQ(schema().fault(nlohmann::json::parse(line)), "");
  EXPECT_EQ(to_json_line(parse_frame_record(line)), line);
}

TEST(FrameRecord, PixelsAreInTheSourcesOrigin) {
  HandPose pose = HandPose::missing(superset_convention());
  pose.joints[0] = {10.0, 20.0, 500.0};
  const HandRecord corner = hand_record(pose, Projection(kCamera), PixelOrigin::corner);
  EXPECT_EQ(corner.landmarks_px[0].u, 10.5);
  EXPECT_EQ(corner.landmarks_px[0].v, 20.5);
  EXPECT_EQ(corner.landmarks_mm[0], Projection(kCamera).to_camera(pose.joints[0]));
  EXPECT_EQ(hand_record(pose, Projection(kCamera), PixelOrigin::centre).landmarks_px[0].u, 10.0);
}

constexpr Landmark kTwo[] = {Landmark::thumb_tip, Landmark::wrist};

TEST(FrameRecord, IsTheLineOfTheDocuments) {
  FrameRecord record;
  record.frame = 12;
  record.name = "000012";
  record.time_s = 0.4;
  HandPose pose{{"two2", kTwo}, {{171.5, 97.5, 448.0}, {}}, {0.75f, 0.0f}};
  for (const HandSide side : {HandSide::left, HandSide::right}) {
    HandRecord hand = hand_record(pose, Projection(kCamera), PixelOrigin::corner);
    hand.id = static_cast<int>(record.hands.size()) + 1;
    hand.side = side;
    hand.score = 0.71;
    record.hands.push_back(hand);
  }
  const std::string rest =
      R"("score":0.7100,"landmarks_mm":{"thumb_tip":[24.000,-44.000,448.000],"wrist":null},)"
      R"("landmarks_px":{"thumb_tip":[172.000,98.000],"wrist":null},"confidence":{"thumb_tip":0.7500,"wrist":0.0000}})";
  EXPECT_EQ(to_json_line(record), R"({"frame":12,"name":"000012","time_s":0.400000,"status":"","hands":[)"
                                  R"({"id":1,"side":"left",)" +
                                      rest + R"(,{"id":2,"side":"right",)" + rest + "]}");
  record.hands.clear();
  record.time_s.reset();
  record.status = "no hand";
  EXPECT_EQ(to_json_line(record),
            R"({"frame":12,"name":"000012","time_s":null,"status":"no hand","hands":[]})");
}

TEST(FrameRecord, RefusesTheWrongNumberOfLandmarks) {
  FrameRecord record = record_with_hands();
  record.hands[0].landmarks_px.pop_back();
  EXPECT_THAT(error_of([&] { to_json_line(record); }), HasSubstr("landmarks in mm"));
}

TEST(FrameRecord, NamesPlaceAndFaultOfALineThatIsNone) {
  const auto fault = [](const std::string& line) {
    return error_of([&] { parse_frame_record(line, "r.jsonl:7"); });
  };
  const auto with_frame = [](const std::string& frame) {
    return R"({"frame":)" + frame + R"(,"name":"a","time_s":null,"status":"","hands":[]})";
  };
  const std::string start = R"({"frame":1,"name":"a","time_s":null,"status":"",)";
  EXPECT_THAT(fault(""), HasSubstr("r.jsonl:7: not JSON"));
  EXPECT_THAT(fault(start), HasSubstr("r.jsonl:7: not JSON"));
  EXPECT_THAT(fault("[1]"), HasSubstr("r.jsonl:7: expected an object, found array"));
  EXPECT_THAT(fault(start + R"("hands":[],"status2":1})"),
              HasSubstr("unknown key 'status2' (did you mean 'status'?)"));
  EXPECT_THAT(fault(R"({"frame":1})"), HasSubstr("lacks the key 'name'"));
  EXPECT_THAT(fault(with_frame("-1")), HasSubstr("frame: is -1, expected 0 to"));
  EXPECT_THAT(fault(start + R"("hands":{}})"), HasSubstr("r.jsonl:7: hands: expected a list"));
  EXPECT_THAT(fault(start + R"("hands":[{"id":1}]})"), HasSubstr("hands[0]: lacks the key 'side'"));
  EXPECT_THAT(fault(with_frame("1.5")), HasSubstr("r.jsonl:7: frame: expected a whole number, found 1.5"));
  EXPECT_THAT(fault(start + R"("hands":[],"latency_ms":"1"})"), HasSubstr("latency_ms: expected a number"));
  const std::string hand = R"("hands":[{"id":1,"side":null,"score":0.5,"landmarks_mm":)";
  EXPECT_THAT(fault(start + hand + R"({"wrist":null},"landmarks_px":{},"confidence":{}}]})"),
              HasSubstr("landmarks of no convention: wrist"));
  EXPECT_THAT(fault(start + R"("hands":[],"hands":[)" + std::string(10000, '[')), HasSubstr("JSON"));
}

TEST(FrameRecord, NamesWhatIsWrongWithAHand) {
  FrameRecord record;
  record.hands.push_back(
      hand_record(HandPose::missing(convention_from_name("nyu14")), Projection(kCamera), {}));
  record.hands[0].id = 1;
  nlohmann::ordered_json good = nlohmann::ordered_json::parse(to_json_line(record));
  const auto fault_after = [&](const auto& spoil) {
    nlohmann::ordered_json line = good;
    spoil(line["hands"][0]);
    return error_of([&] { parse_frame_record(line.dump(), "r.jsonl:7"); });
  };
  EXPECT_NO_THROW(parse_frame_record(good.dump()));
  EXPECT_THAT(fault_after([](auto& hand) { hand["landmarks_px"]["elbow"] = nullptr; }),
              HasSubstr("r.jsonl:7: hands[0]: landmarks_px.elbow: is not the next landmark of nyu14"));
  EXPECT_THAT(fault_after([](auto& hand) {
                const auto first = hand["landmarks_px"].begin().key();
                hand["landmarks_px"].erase(first);
                hand["landmarks_px"][first] = nullptr;
              }),
              HasSubstr("is not the next landmark of nyu14"));
  EXPECT_THAT(fault_after([](auto& hand) { hand["landmarks_px"] = nlohmann::ordered_json::object(); }),
              HasSubstr("r.jsonl:7: hands[0]: landmarks_px: has 0 landmarks, expected 14"));
  EXPECT_THAT(fault_after([](auto& hand) { hand["side"] = "up"; }),
              HasSubstr("hands[0]: side: is 'up', expected right, left or null"));
  EXPECT_THAT(fault_after([](auto& hand) { hand["side"] = 1; }), HasSubstr("side: expected a text, found 1"));
  EXPECT_THAT(fault_after([](auto& hand) { hand["score"] = "high"; }),
              HasSubstr("score: expected a number, found string"));
  EXPECT_THAT(fault_after([](auto& hand) { hand["landmarks_mm"] = 3; }),
              HasSubstr("landmarks_mm: expected an object, found 3"));
  EXPECT_THAT(fault_after([](auto& hand) {
                hand["landmarks_mm"].front() = {1, 2};
              }),
              HasSubstr("expected a list of 3 numbers or null"));
  EXPECT_THAT(fault_after([](auto& hand) { hand["landmarks_px"].front() = 1; }),
              HasSubstr("expected a list of 2 numbers or null"));
  EXPECT_THAT(fault_after([](auto& hand) {
                hand["landmarks_px"].front() = {1, "2"};
              }),
              HasSubstr("expected a number, found string"));
  EXPECT_THAT(fault_after([](auto& hand) { hand["id"] = std::uint64_t{1} << 63; }),
              HasSubstr("id: is 9223372036854775808, expected 1 to 2147483647"));
  EXPECT_THAT(fault_after([](auto& hand) { hand["id"] = std::int64_t{1} << 31; }),
              HasSubstr("id: is 2147483648, expected 1 to 2147483647"));
  EXPECT_THAT(fault_after([](auto& hand) { hand["id"] = 0; }), HasSubstr("id: is 0, expected 1 to"));
  EXPECT_THAT(fault_after([](auto& hand) { hand["angles_rad"] = 1; }),
              HasSubstr("angles_rad: expected an object"));
}

TEST(FrameRecord, EveryLineCutShortIsRefused) {
  const std::string line = to_json_line(record_with_hands());
  for (std::size_t length = 0; length < line.size(); length += 1 + length / 100)
    EXPECT_NE(error_of([&] { parse_frame_record(line.substr(0, length)); }), "") << length;
}

}  // namespace
}  // namespace knuckle
