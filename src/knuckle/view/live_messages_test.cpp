// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/live_messages.h"

#include <cmath>
#include <cstring>

#include <nlohmann/json.hpp>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/data/fitted_hand_testing.h"

namespace knuckle {
namespace {

using nlohmann::json;

constexpr Camera kCamera{.width = 13, .height = 7, .fx = 20.5, .fy = 21.0, .cx = 6.0, .cy = 3.0};

std::shared_ptr<Frame> frame_in(double unit_mm, bool has_infrared) {
  auto frame = std::make_shared<Frame>();
  Random random(1, 2);
  frame->camera = kCamera;
  frame->depth_mm = Image<float>(kCamera.width, kCamera.height);
  for (float& depth : frame->depth_mm.pixels())
    depth = static_cast<float>(static_cast<double>(random.below(65536)) * unit_mm);
  if (has_infrared) frame->infrared = Image<std::uint16_t>(kCamera.width, kCamera.height, 4711);
  return frame;
}

struct Message {
  json header;
  std::vector<std::uint16_t> pixels;
};

Message parsed(const std::vector<std::uint8_t>& bytes) {
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data(), sizeof(size));
  EXPECT_EQ(size % 4, 0U);
  const std::string text(bytes.begin() + 4, bytes.begin() + 4 + size);
  Message message{json::parse(text), {}};
  message.pixels.resize((bytes.size() - 4 - size) / 2);
  std::memcpy(message.pixels.data(), bytes.data() + 4 + size, message.pixels.size() * 2);
  return message;
}

TEST(LiveMessages, AFrameHoldsItsDepthToTheBit) {
  for (const double unit_mm : {1.0, 0.25, 0.1}) {
    for (const bool has_infrared : {false, true}) {
      const auto frame = frame_in(unit_mm, has_infrared);
      const Message message = parsed(frame_message({frame, {}, {}, 5, 2}));
      EXPECT_EQ(message.header["width"], 13);
      EXPECT_EQ(message.header["height"], 7);
      EXPECT_EQ(message.header["depth_unit_mm"], unit_mm);
      EXPECT_EQ(message.header["infrared"], has_infrared);
      EXPECT_EQ(message.header["arrived"], 5);
      EXPECT_EQ(message.header["passed_over"], 2);
      ASSERT_EQ(message.pixels.size(), 13U * 7U * (has_infrared ? 2U : 1U));
      for (std::size_t i = 0; i < 13U * 7U; ++i)
        EXPECT_EQ(static_cast<float>(message.pixels[i] * unit_mm), frame->depth_mm.pixels()[i]);
      for (std::size_t i = 13U * 7U; i < message.pixels.size(); ++i) EXPECT_EQ(message.pixels[i], 4711);
    }
  }
}

TEST(LiveMessages, DepthThatIsNoneIsZeroAndWhatIsTooFarToo) {
  const auto frame = frame_in(1.0, false);
  const float odd[] = {std::nanf(""), INFINITY, -INFINITY, -5.0f, 0.0f, 1e30f, 65536.0f};
  std::ranges::copy(odd, frame->depth_mm.pixels().begin());
  const Message message = parsed(frame_message({frame, {}, {}, 0, 0}));
  for (std::size_t i = 0; i < std::size(odd); ++i) EXPECT_EQ(message.pixels[i], 0) << i;
  EXPECT_EQ(message.pixels[7], frame->depth_mm.pixels()[7]);
}

TEST(LiveMessages, TheHeaderHoldsTheRecordAsItIsWrittenElsewhere) {
  LiveUpdate update{frame_in(1.0, false), {}, {.file = "a.h5", .frames = 3, .dropped = 1}, 0, 0};
  update.record.frame = 12;
  update.record.name = "na\"me\xff";
  update.record.latency_ms = 4.5;
  update.record.hands = {testing::fitted_hand({10.0, 20.0, 500.0}), HandRecord()};
  update.record.hands[1].convention = superset_convention();
  update.record.hands[1].landmarks_mm.assign(kSupersetSize, Point3::Constant(kNaN));
  update.record.hands[1].landmarks_px.resize(kSupersetSize);
  const Message message = parsed(frame_message(update));
  EXPECT_EQ(message.header["record"], json::parse(to_json_line(update.record)));
  EXPECT_EQ(message.header["recording"], json::parse(R"({"file":"a.h5","frames":3,"dropped":1,"fault":""})"));
  EXPECT_EQ(message.header["camera"]["fx"], 20.5);
  EXPECT_EQ(message.header["camera"]["model"], "projective");
  ASSERT_EQ(message.header["surface"].size(), 2U) << "one list per hand";
  EXPECT_EQ(message.header["surface"][0].size(), 19U);
  EXPECT_EQ(message.header["surface"][1].size(), 0U) << "no model was fitted to it";
}

TEST(LiveMessages, InfoSaysWhatThePageNeeds) {
  const LiveInfo info{.version = "1.2",
                      .source = "h5:\xff",
                      .pipeline = "p.toml",
                      .convention = convention_from_name("mediapipe21"),
                      .can_record = true};
  const json before = json::parse(info_message(info, {}, nullptr));
  EXPECT_TRUE(before["camera"].is_null());
  EXPECT_EQ(before["version"], "1.2");
  EXPECT_EQ(before["convention"], "mediapipe21");
  EXPECT_EQ(before["landmarks"].size(), 21U);
  EXPECT_EQ(before["bones"].size(), 20U);
  EXPECT_EQ(before["bones"][0].size(), 2U);
  EXPECT_TRUE(before["can_record"].get<bool>());
  EXPECT_TRUE(before["recording"]["file"].is_null());
  const LiveUpdate update{frame_in(1.0, false), {}, {}, 0, 0};
  EXPECT_EQ(json::parse(info_message(info, {}, &update))["camera"]["width"], 13);
}

}  // namespace
}  // namespace knuckle
