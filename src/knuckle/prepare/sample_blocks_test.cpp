// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/sample_blocks.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "knuckle/core/interruption.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/prepare/fresh_samples.h"
#include "knuckle/prepare/sample_file.h"
#include "knuckle/prepare/stream_testing.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;
using testing::MadeUpCutter;
using ::testing::Not;
using testing::tiny_samples;

constexpr std::int64_t kFramesCut = 2 * SampleBlocks::kFrames + 100;

std::vector<std::int64_t> all_of(const SampleStream& stream) {
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(stream.size()));
  std::iota(numbers.begin(), numbers.end(), std::int64_t{0});
  return numbers;
}

CubeSamples fetched(const SampleStream& stream, const std::vector<std::int64_t>& numbers) {
  CubeSamples samples = stream.room_for(std::ssize(numbers));
  stream.fetch(numbers, samples, 0);
  samples.finish();
  return samples;
}

bool are_equal(const CubeSample& a, const CubeSample& b) {
  const auto is_same = [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return std::ranges::equal(a.codes, b.codes) && std::ranges::equal(a.joints, b.joints, is_same) &&
         a.centre_mm == b.centre_mm;
}

/// Three blocks of made-up samples, the last of 100 frames.
class SampleBlocksTest : public ::testing::Test {
 protected:
  std::unique_ptr<SampleBlocks> open(std::int64_t breaks_at = -1, std::int64_t unused = 7) {
    SampleBlocks::Making making{{}, tiny_samples(), "samples", {}};
    making.inputs.add("set", set_);
    making.cutter = [this, breaks_at, unused] {
      auto cutter = std::make_unique<MadeUpCutter>(kFramesCut, unused);
      cutter->breaks_at = breaks_at;
      cutter_ = cutter.get();
      return cutter;
    };
    cutter_ = nullptr;
    return SampleBlocks::opened(folder_ / "set", making);
  }
  std::filesystem::path block(int number) const {
    return folder_ / "set" / fmt::format("block_{:06}.h5", number);
  }
  std::filesystem::path index() const { return folder_ / "set" / "index.h5"; }

  testing::TemporaryFolder folder_;
  std::string set_ = "one";
  const MadeUpCutter* cutter_ = nullptr;  ///< the last; valid while it is at work
};

TEST_F(SampleBlocksTest, HoldTheSamplesOfAllFramesThatCanBeUsed) {
  const auto blocks = open();
  CubeSamples expected = room_for_samples(kFramesCut, tiny_samples());
  std::int64_t without_hand = 0;
  for (std::int64_t i = 0; i < kFramesCut; ++i) {
    const auto outcome = MadeUpCutter(kFramesCut, 7).cut(i, expected, i);
    without_hand += outcome == SampleCutter::Outcome::without_hand ? 1 : 0;
  }
  expected.finish();
  ASSERT_EQ(blocks->size(), expected.size());
  EXPECT_EQ(blocks->frames().total, kFramesCut);
  EXPECT_EQ(blocks->frames().without_hand, without_hand);
  EXPECT_EQ(blocks->frames().used(), expected.size());
  EXPECT_THAT(blocks->runs(), ElementsAre(877, 878, 86));
  std::vector<bool> known(14, true);
  known[0] = false;
  EXPECT_EQ(blocks->known_joints(), known);
  const CubeSamples all = fetched(*blocks, all_of(*blocks));
  for (std::int64_t i = 0; i < all.size(); ++i)
    ASSERT_TRUE(are_equal(all.sample(i), expected.sample(i))) << i;
  const std::vector<std::int64_t> some{0, 3, 876, 877, 1754, 1755, 1840};
  const CubeSamples few = fetched(*blocks, some);
  for (std::size_t i = 0; i < some.size(); ++i)
    EXPECT_TRUE(are_equal(few.sample(static_cast<std::int64_t>(i)), expected.sample(some[i]))) << i;
}

TEST_F(SampleBlocksTest, AreOpenedWithoutTheirFramesWhereAllAreThere) {
  open();
  const auto written = std::filesystem::last_write_time(block(0));
  open(0);
  EXPECT_EQ(cutter_, nullptr);
  EXPECT_EQ(std::filesystem::last_write_time(block(0)), written);
}

TEST_F(SampleBlocksTest, GoOnWhereTheirMakingStopped) {
  const auto whole = open();
  const CubeSamples expected = fetched(*whole, all_of(*whole));
  const auto expect_all = [&](const SampleBlocks& blocks) {
    EXPECT_EQ(blocks.frames().total, kFramesCut);
    ASSERT_EQ(blocks.size(), expected.size());
    const CubeSamples all = fetched(blocks, all_of(blocks));
    for (std::int64_t i = 0; i < all.size(); ++i)
      ASSERT_TRUE(are_equal(all.sample(i), expected.sample(i))) << i;
  };
  std::filesystem::remove_all(folder_ / "set");
  EXPECT_THAT(error_of([&] { open(1500); }), HasSubstr("frame 1500 breaks"));
  EXPECT_TRUE(std::filesystem::exists(block(0)));
  EXPECT_FALSE(std::filesystem::exists(block(1)));
  EXPECT_FALSE(std::filesystem::exists(index()));
  expect_all(*open(100));  // frame 100 is not cut out again
  std::filesystem::remove(block(1));
  expect_all(*open(100));
}

TEST_F(SampleBlocksTest, EndTheirMakingWhereTheProgramIsToEnd) {
  set_interrupted(true);
  EXPECT_THROW(open(), Interrupted);
  set_interrupted(false);
  const auto blocks = open();
  set_interrupted(true);
  EXPECT_THROW(fetched(*blocks, {0}), Interrupted);
  set_interrupted(false);
}

TEST_F(SampleBlocksTest, HaveNoFileWhereNoFrameCanBeUsed) {
  const auto blocks = open(-1, 1);
  EXPECT_EQ(blocks->size(), 0);
  EXPECT_FALSE(std::filesystem::exists(block(0)));
  open(0, 1);
  EXPECT_EQ(cutter_, nullptr) << "known from the index";
}

TEST_F(SampleBlocksTest, AreNamedWhereTheyAreCutShortMissingOrOfAnotherSet) {
  const auto blocks = open();
  const std::string whole = read_text_file(block(1));
  const auto names_it = AllOf(HasSubstr("block_000001.h5"), Not(HasSubstr("\n")));
  const auto fault = [&] { return error_of([&] { fetched(*blocks, {0, 1000}); }); };
  std::filesystem::resize_file(block(1), whole.size() - 1000);
  EXPECT_THAT(fault(), names_it);
  EXPECT_THAT(error_of([&] { open(); }), AllOf(names_it, HasSubstr("bytes"), HasSubstr("remove the file")));
  SampleBlocks::Making fewer{{}, tiny_samples(), "samples", {}};
  fewer.inputs.add("set", set_);
  fewer.cutter = [] { return std::make_unique<MadeUpCutter>(kFramesCut, 3); };
  SampleBlocks::opened(folder_ / "fewer", fewer);
  std::filesystem::copy_file(folder_ / "fewer" / "block_000001.h5", block(1),
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_THAT(fault(), AllOf(names_it, HasSubstr("is not the block that it was")));
  std::filesystem::copy_file(block(0), block(1), std::filesystem::copy_options::overwrite_existing);
  EXPECT_THAT(fault(), AllOf(names_it, HasSubstr("other sources or options")));
  std::filesystem::remove(block(1));
  EXPECT_THAT(fault(), AllOf(names_it, HasSubstr("missing")));
  set_ = "another";
  EXPECT_THAT(error_of([&] { open(); }), AllOf(HasSubstr("index.h5"), HasSubstr("other sources or options")));
}

TEST_F(SampleBlocksTest, AreNamedWhereTheyHaveOtherSamplesThanBefore) {
  const auto blocks = open();
  std::filesystem::remove(index());
  std::filesystem::remove(block(1));
  open(-1, 5);  // other frames cannot be used
  EXPECT_THAT(error_of([&] { fetched(*blocks, {1200}); }),
              AllOf(HasSubstr("block_000001.h5"), HasSubstr("is not the block that it was; remove it")));
}

TEST_F(SampleBlocksTest, OfWhichAnyByteIsDamagedAreNamedOrGiveTheSameSamples) {
  const auto blocks = open();
  const std::vector<std::int64_t> numbers = all_of(*blocks);
  const CubeSamples whole = fetched(*blocks, numbers);
  const std::string text = read_text_file(block(2));
  int refused = 0;
  int flips = 0;
  for (std::size_t i = 0; i < text.size(); i += 61, ++flips) {
    std::string damaged = text;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    write_text_file(block(2), damaged);
    const std::vector<std::int64_t> last(numbers.end() - 86, numbers.end());
    CubeSamples samples = blocks->room_for(86);
    try {
      blocks->fetch(last, samples, 0);
    } catch (const Error& error) {
      ++refused;
      EXPECT_THAT(error.what(), AllOf(HasSubstr("block_000002.h5"), Not(HasSubstr("\n")))) << i;
      continue;
    }
    samples.finish();
    for (std::int64_t s = 0; s < samples.size(); ++s)
      ASSERT_TRUE(are_equal(samples.sample(s), whole.sample(last[static_cast<std::size_t>(s)]))) << i;
  }
  EXPECT_GT(refused, flips / 4);
}

TEST_F(SampleBlocksTest, HaveAnIndexWhoseDamageIsNamed) {
  open();
  const std::string text = read_text_file(index());
  for (const std::size_t length : {std::size_t{0}, text.size() / 2}) {
    std::filesystem::resize_file(index(), length);
    EXPECT_THAT(error_of([&] { open(); }), AllOf(HasSubstr("index.h5"), Not(HasSubstr("\n"))));
  }
  write_block_index(index(), {{{1024, 2000, 0}, 10, std::vector<bool>(14)}}, Inputs().add("set", set_));
  EXPECT_THAT(error_of([&] { open(); }), AllOf(HasSubstr("index.h5"), HasSubstr("damaged")));
  std::filesystem::remove(index());
  EXPECT_EQ(open(0)->frames().total, kFramesCut) << "from the blocks";
  EXPECT_EQ(read_text_file(index()).size(), text.size());
}

TEST_F(SampleBlocksTest, NameAFolderThatCannotBeMade) {
  write_text_file(folder_ / "set", "");
  EXPECT_THAT(error_of([&] { open(); }), HasSubstr("set"));
}

TEST(FreshSamples, AreThoseOfTheirFramesOrOfTheNextThatCanBeUsed) {
  const FreshSamples samples("set", std::make_unique<MadeUpCutter>(21, 7), tiny_samples());
  EXPECT_EQ(samples.size(), 21);
  EXPECT_THAT(samples.runs(), ElementsAre(21));
  const CubeSamples some = fetched(samples, {0, 1, 5, 7, 20});
  std::vector<double> frames;
  for (std::int64_t i = 0; i < some.size(); ++i) frames.push_back(some.sample(i).centre_mm.z());
  EXPECT_THAT(frames, ElementsAre(1, 1, 5, 8, 20));
  std::vector<bool> known(14, true);
  known[0] = false;
  EXPECT_EQ(samples.known_joints(), known);
}

TEST(FreshSamples, NameASourceOfWhichNoFrameCanBeUsed) {
  EXPECT_THAT(
      error_of([] { FreshSamples("folder:set", std::make_unique<MadeUpCutter>(5, 1), tiny_samples()); }),
      AllOf(HasSubstr("folder:set"), HasSubstr("none of 5 frames")));
}

}  // namespace
}  // namespace knuckle
