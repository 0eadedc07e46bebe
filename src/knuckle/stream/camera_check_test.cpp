// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/camera_check.h"

#include <functional>

#include <gmock/gmock.h>

#include "knuckle/core/random.h"

namespace knuckle {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A camera whose frames a function draws, 25 per second.
class DrawnStream final : public FrameStream {
 public:
  DrawnStream(int count, std::function<void(Image<float>&, int)> draw, std::int64_t lost = 0)
      : count_(count), draw_(std::move(draw)), lost_(lost) {}
  std::optional<Frame> next() override {
    if (index_ == count_) return std::nullopt;
    Frame frame;
    frame.depth_mm = Image<float>(80, 60);
    draw_(frame.depth_mm, index_);
    frame.time_s = 0.04 * index_++;
    return frame;
  }
  std::int64_t lost_frames() const override { return lost_; }

 private:
  int count_;
  std::function<void(Image<float>&, int)> draw_;
  std::int64_t lost_;
  int index_ = 0;
};

const CameraFacts kKnown{.device = "", .format = "", .intrinsics = "from c.toml"};

/// A wall with this noise, a quarter of it not measured.
DrawnStream wall(double depth_mm, double noise_mm) {
  return {20, [=](Image<float>& image, int index) {
            Random random(7, static_cast<std::uint64_t>(index));
            for (float& pixel : image.pixels())
              pixel = static_cast<float>(depth_mm + noise_mm * random.normal());
            for (int row = 0; row < 15; ++row) std::ranges::fill(image.row(row), 0.0f);
          }};
}

TEST(CameraCheck, MeasuresRateShareRangeAndNoise) {
  DrawnStream stream = wall(800.0, 3.0);
  const CameraCheck check = check_camera(stream);
  EXPECT_EQ(check.frames, 20);
  EXPECT_EQ(check.width, 80);
  EXPECT_NEAR(check.rate_hz, 25.0, 1e-9);
  EXPECT_DOUBLE_EQ(check.measured_share, 0.75);
  EXPECT_NEAR(*check.median_mm, 800.0, 0.3);
  EXPECT_NEAR(*check.nearest_mm, 800.0 - 2.33 * 3.0, 0.6);
  EXPECT_NEAR(*check.farthest_mm, 800.0 + 2.33 * 3.0, 0.6);
  EXPECT_NEAR(*check.noise_mm, 3.0, 0.2);
  EXPECT_THAT(remarks_on(check, kKnown), IsEmpty());
}

TEST(CameraCheck, EndsAtItsLimits) {
  DrawnStream many = wall(800.0, 1.0);
  EXPECT_EQ(check_camera(many, {.most_frames = 5}).frames, 5);
  DrawnStream longer = wall(800.0, 1.0);
  EXPECT_EQ(check_camera(longer, {.most_frames = 90, .most_seconds = 0.2}).frames, 6);
}

TEST(CameraCheck, SaysWhatIsWrong) {
  const auto remarks = [](DrawnStream stream, const CameraFacts& facts = kKnown) {
    return remarks_on(check_camera(stream), facts);
  };
  EXPECT_THAT(remarks(wall(800.0, 1.0), {}), Contains(HasSubstr("intrinsics are not known")));
  EXPECT_THAT(remarks(wall(20000.0, 1.0)), Contains(HasSubstr("unit")));
  EXPECT_THAT(remarks(wall(30.0, 1.0)), Contains(HasSubstr("unit")));
  EXPECT_THAT(remarks(wall(800.0, 0.0)), Contains(HasSubstr("the same image")));
  EXPECT_THAT(remarks({20, [](Image<float>&, int) {}}), Contains(HasSubstr("no pixel is measured")));
  EXPECT_THAT(remarks({0, [](Image<float>&, int) {}}), Contains("no frame came"));
  const auto dot = [](Image<float>& image, int index) { image(index, 3) = 700.0f; };
  EXPECT_THAT(remarks({20,
                       [&](Image<float>& image, int index) {
                         for (int step = 0; step < 60; ++step) dot(image, (index + step) % 80);
                       }}),
              Contains(HasSubstr("only 1 % of the pixels")));
  EXPECT_THAT(remarks({20,
                       [](Image<float>& image, int index) {
                         std::ranges::fill(image.pixels(), 500.0f + static_cast<float>(index));
                       },
                       5}),
              Contains(HasSubstr("5 of 25 frames were lost")));
}

}  // namespace
}  // namespace knuckle
