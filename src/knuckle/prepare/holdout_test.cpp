// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/holdout.h"

#include <algorithm>
#include <set>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::SizeIs;

/// Frames of which nothing is known but their sequences.
class Sequences final : public FrameSource {
 public:
  explicit Sequences(std::vector<int> of_frames) : of_frames_(std::move(of_frames)) {}
  std::int64_t size() const override { return std::ssize(of_frames_); }
  Frame read(std::int64_t /*index*/) const override { fail("no images are needed"); }
  FrameLabel read_label(std::int64_t index) const override {
    FrameLabel label;
    label.sequence = of_frames_[static_cast<std::size_t>(index)];
    return label;
  }
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  std::vector<int> of_frames_;
};

/// Sequences of so many frames, one after another.
Sequences sequences_of(const std::vector<int>& lengths) {
  std::vector<int> of_frames;
  for (std::size_t i = 0; i < lengths.size(); ++i)
    of_frames.insert(of_frames.end(), static_cast<std::size_t>(lengths[i]), static_cast<int>(i));
  return Sequences(of_frames);
}

std::vector<std::int64_t> held_out(const Sequences& source, double share) {
  return frames_of_part(source, {share, Holdout::Part::validation}, "set");
}

TEST(Holdout, TakesWholeSequencesAndLeavesTheRest) {
  const std::vector<int> lengths{7, 3, 12, 5, 9, 1, 8, 15, 20, 20};
  const Sequences source = sequences_of(lengths);
  for (const double share : {0.05, 0.1, 0.3, 0.5, 0.9}) {
    const std::vector<std::int64_t> validation = held_out(source, share);
    const std::vector<std::int64_t> training =
        frames_of_part(source, {share, Holdout::Part::training}, "set");
    EXPECT_NEAR(static_cast<double>(validation.size()), 100.0 * share, 5.0) << share;
    std::vector<std::int64_t> all(100);
    std::ranges::merge(training, validation, all.begin());
    for (std::int64_t i = 0; i < 100; ++i) ASSERT_EQ(all[static_cast<std::size_t>(i)], i) << share;
    std::set<int> seen;
    for (const std::int64_t i : training) seen.insert(source.read_label(i).sequence);
    for (const std::int64_t i : validation)
      EXPECT_FALSE(seen.contains(source.read_label(i).sequence)) << share;
  }
}

TEST(Holdout, TakesAtLeastOneSequenceAndLeavesOne) {
  EXPECT_THAT(held_out(sequences_of({100, 40}), 0.01), SizeIs(40)) << "the shorter one";
  EXPECT_THAT(held_out(sequences_of({50, 50}), 0.9), SizeIs(50));
}

TEST(Holdout, OfNothingIsAll) {
  EXPECT_THAT(frames_of_part(sequences_of({4}), {}, "set"), ::testing::ElementsAre(0, 1, 2, 3));
}

TEST(Holdout, DoesNotPartOneSequence) {
  EXPECT_THAT(error_of([] { held_out(sequences_of({30}), 0.1); }),
              AllOf(HasSubstr("set: "), HasSubstr("one sequence"), HasSubstr("sequences.txt")));
}

}  // namespace
}  // namespace knuckle
