// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/stored_frame.h"

#include <functional>
#include <limits>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::StartsWith;

StoredFrame small_frame() {
  StoredFrame frame;
  frame.camera = {CameraModel::projective, 8, 6, 20.0, 21.0, 4.0, 3.0, {}};
  frame.side = 1;
  frame.time_s = 2.5;
  frame.sequence = 3;
  frame.depth = {1, 2, 3};
  frame.mask = {4, 5};
  frame.hands = {{.side = 2, .visible_share = 0.5}, {.side = 1}};
  return frame;
}

std::string fault_of_bytes(const std::vector<std::uint8_t>& bytes) {
  return error_of([&] { stored_frame_from(bytes, "a.h5.partial: frame 7"); });
}

TEST(StoredFrame, IsReadFromItsBytes) {
  const StoredFrame frame = stored_frame_from(to_bytes(small_frame()), "log");
  EXPECT_EQ(frame.camera, small_frame().camera);
  EXPECT_EQ(frame.side, 1);
  EXPECT_EQ(frame.time_s, 2.5);
  EXPECT_EQ(frame.sequence, 3);
  EXPECT_EQ(frame.depth, small_frame().depth);
  EXPECT_TRUE(frame.infrared.empty());
  EXPECT_EQ(frame.mask, small_frame().mask);
  ASSERT_EQ(frame.hands.size(), 2u);
  EXPECT_EQ(frame.hands[0].visible_share, 0.5);
  EXPECT_EQ(frame.hands[1].side, 1);
}

TEST(StoredFrame, CutShortAnywhereOrTooLongIsRefused) {
  std::vector<std::uint8_t> bytes = to_bytes(small_frame());
  bytes.push_back(0);
  EXPECT_THAT(fault_of_bytes(bytes),
              AllOf(StartsWith("a.h5.partial: frame 7: "), HasSubstr("something follows it")));
  while (!bytes.empty()) {
    bytes.pop_back();
    if (bytes.size() == to_bytes(small_frame()).size()) continue;
    ASSERT_THAT(fault_of_bytes(bytes),
                AllOf(StartsWith("a.h5.partial: frame 7: "), HasSubstr("ends too early")));
  }
}

TEST(StoredFrame, LengthsAndCamerasThatNoFrameHasAreRefused) {
  const auto fault_with = [](const std::function<void(StoredFrame&)>& change) {
    StoredFrame frame = small_frame();
    change(frame);
    return fault_of_bytes(to_bytes(frame));
  };
  const auto is_damaged = HasSubstr("a.h5.partial: frame 7: the record of the frame is damaged");
  EXPECT_THAT(fault_with([](StoredFrame& frame) { frame.camera.width = -1; }), is_damaged);
  EXPECT_THAT(
      fault_with([](StoredFrame& frame) { frame.camera.fx = std::numeric_limits<double>::quiet_NaN(); }),
      is_damaged);
  EXPECT_THAT(fault_with([](StoredFrame& frame) { frame.camera.model = static_cast<CameraModel>(9); }),
              is_damaged);
  EXPECT_THAT(fault_with([](StoredFrame& frame) { frame.hands.resize(65); }), is_damaged);
}

}  // namespace
}  // namespace knuckle
