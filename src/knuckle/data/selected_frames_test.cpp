// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/selected_frames.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;

/// Frames named by their index.
class CountingSource final : public FrameSource {
 public:
  explicit CountingSource(std::int64_t size) : size_(size) {}
  std::int64_t size() const override { return size_; }
  Frame read(std::int64_t index) const override {
    Frame frame;
    frame.name = std::to_string(index);
    frame.camera.fx = static_cast<double>(index);
    frame.time_s = 0.5 * static_cast<double>(index);
    frame.sequence = static_cast<int>(index / 4);
    return frame;
  }
  std::optional<Convention> convention() const override { return convention_from_name("icg20"); }
  PixelOrigin pixel_origin() const override { return PixelOrigin::corner; }

 private:
  std::int64_t size_;
};

std::vector<std::string> names(const FrameSelection& selection, std::int64_t size = 10) {
  const auto source = select_frames(std::make_unique<CountingSource>(size), selection, "test");
  std::vector<std::string> result;
  for (std::int64_t i = 0; i < source->size(); ++i) result.push_back(source->read(i).name);
  return result;
}

TEST(SelectedFrames, TakesFirstCountAndStep) {
  EXPECT_THAT(names({2, 3, 1}), ElementsAre("2", "3", "4"));
  EXPECT_THAT(names({1, 3, 4}), ElementsAre("1", "5", "9"));
  EXPECT_EQ(names({}).size(), 10u);
}

TEST(SelectedFrames, GivesWhatThereIsWhereCountAsksForMore) {
  EXPECT_THAT(names({8, 100, 1}), ElementsAre("8", "9"));
  EXPECT_THAT(names({0, 100, 9}), ElementsAre("0", "9"));
  EXPECT_THAT(names({0, 100, 10}), ElementsAre("0"));
}

TEST(SelectedFrames, LabelsAreThoseOfTheSelectedFrames) {
  const auto source = select_frames(std::make_unique<CountingSource>(10), {2, 3, 3}, "test");
  EXPECT_EQ(source->read_label(1).camera.fx, 5.0);
  EXPECT_EQ(source->read_label(2).camera.fx, 8.0);
}

TEST(SelectedFrames, KeepTheirTimesAndSequences) {
  const auto source = select_frames(std::make_unique<CountingSource>(10), {2, 3, 3}, "test");
  for (const std::int64_t i : {0, 1, 2}) {
    const std::int64_t index = 2 + 3 * i;
    EXPECT_EQ(source->read(i).time_s, 0.5 * static_cast<double>(index));
    EXPECT_EQ(source->read_label(i).time_s, 0.5 * static_cast<double>(index));
    EXPECT_EQ(source->read(i).sequence, index / 4);
    EXPECT_EQ(source->read_label(i).sequence, index / 4);
  }
}

TEST(SelectedFrames, KeepsConventionAndPixelOrigin) {
  const auto source = select_frames(std::make_unique<CountingSource>(3), {1, 1, 1}, "test");
  EXPECT_EQ(source->convention()->name, "icg20");
  EXPECT_EQ(source->pixel_origin(), PixelOrigin::corner);
}

TEST(SelectedFrames, RefusesAnEmptySelectionAndIndicesOutOfRange) {
  EXPECT_THAT(error_of([] {
                names({10, 1, 1});
              }),
              AllOf(HasSubstr("test"), HasSubstr("first=10"), HasSubstr("10")));
  EXPECT_THAT(error_of([] { names({0, 1, 0}); }), HasSubstr("step"));
  const auto source = select_frames(std::make_unique<CountingSource>(3), {1, 1, 1}, "test");
  EXPECT_THAT(error_of([&] { source->read(1); }), HasSubstr("out of range"));
  EXPECT_THAT(error_of([&] { source->read(-1); }), HasSubstr("out of range"));
}

}  // namespace
}  // namespace knuckle
