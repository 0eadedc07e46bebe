// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/frame_stream.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;

/// Five frames named by their index, of which frame 2 cannot be read.
class FaultySource final : public FrameSource {
 public:
  std::int64_t size() const override { return 5; }
  Frame read(std::int64_t index) const override {
    if (index == 2) fail("frame 2 is damaged");
    Frame frame;
    frame.name = std::to_string(index);
    return frame;
  }
  std::optional<Convention> convention() const override { return std::nullopt; }
};

/// The names that a stream gives, a fault's message in its place.
std::vector<std::string> played(FrameStream& stream) {
  std::vector<std::string> names;
  while (true) {
    try {
      const std::optional<Frame> frame = stream.next();
      if (!frame) return names;
      names.push_back(frame->name);
    } catch (const Error& error) {
      names.emplace_back(error.what());
    }
  }
}

TEST(SourceStream, GivesTheFramesInOrderAndThenNothing) {
  const FaultySource source;
  SourceStream stream(source, 3);
  EXPECT_THAT(played(stream), ElementsAre("3", "4"));
  EXPECT_FALSE(stream.next().has_value());
}

TEST(SourceStream, GoesOnAfterAFrameThatCannotBeRead) {
  SourceStream stream(std::make_unique<FaultySource>());
  EXPECT_THAT(played(stream), ElementsAre("0", "1", "frame 2 is damaged", "3", "4"));
}

TEST(SourceStream, PlaysARange) {
  const FaultySource source;
  SourceStream stream(source, 0, 2);
  EXPECT_THAT(played(stream), ElementsAre("0", "1"));
  SourceStream empty(source, 5);
  EXPECT_THAT(played(empty), ElementsAre());
}

TEST(SourceStream, RefusesARangeThatIsNotInTheSource) {
  const FaultySource source;
  EXPECT_THAT(error_of([&] { SourceStream(source, -1); }), HasSubstr("[-1, 5)"));
  EXPECT_THAT(error_of([&] { SourceStream(source, 3, 2); }), HasSubstr("[3, 2)"));
  EXPECT_THAT(error_of([&] { SourceStream(source, 0, 6); }), HasSubstr("the source has 5"));
}

}  // namespace
}  // namespace knuckle
