// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/set_depth_unit.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

/// Frames of one pixel and of one that was not measured; a depth below 0 cannot be read.
class PixelFrames final : public FrameSource {
 public:
  explicit PixelFrames(std::vector<float> depths_mm) : depths_mm_(std::move(depths_mm)) {}
  std::int64_t size() const override { return std::ssize(depths_mm_); }
  Frame read(std::int64_t index) const override {
    const float depth_mm = depths_mm_.at(static_cast<std::size_t>(index));
    if (depth_mm < 0.0f) fail("frame {} is damaged", index);
    Frame frame;
    frame.depth_mm = Image<float>(2, 1);
    frame.depth_mm(0, 0) = depth_mm;
    return frame;
  }
  FrameLabel read_label(std::int64_t /*index*/) const override { return {}; }
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  std::vector<float> depths_mm_;
};

double unit_of(std::vector<float> depths_mm) {
  return set_depth_unit_mm(PixelFrames(std::move(depths_mm)));
}

TEST(SetDepthUnit, KeepsTheBitsOfAllFrames) {
  EXPECT_EQ(unit_of({650.0f, 7045.0f, 65535.0f}), 1.0);  // a Kinect's room
  EXPECT_EQ(unit_of({650.0f, 700.25f, 7045.0f}), 0.25);
  EXPECT_EQ(unit_of({650.0f, 700.25f, 700.125f}), 0.125);
  EXPECT_EQ(unit_of({0.0f}), 1.0);
  EXPECT_EQ(unit_of({}), 1.0);
}

TEST(SetDepthUnit, ReachesTheFarthestWhereNoneKeepsTheBits) {
  EXPECT_EQ(unit_of({650.0f, 700.33f, 6553.0f}), 0.1);
  EXPECT_EQ(unit_of({700.33f, 6554.0f}), 1.0);
  EXPECT_EQ(unit_of({6554.0f, 700.33f}), 1.0);
}

TEST(SetDepthUnit, SaysWhichFrameCannotBeRead) {
  EXPECT_EQ(testing::error_of([] { unit_of({650.0f, -1.0f}); }), "frame 1 is damaged");
}

}  // namespace
}  // namespace knuckle
