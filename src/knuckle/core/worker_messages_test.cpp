// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/worker_messages.h"

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "knuckle/core/testing.h"
#include "knuckle/core/worker_group_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

/// A group of two whose other worker says that its message has so many bytes.
class AnnouncingWorkers final : public WorkerGroup {
 public:
  explicit AnnouncingWorkers(std::int64_t announced) : announced_(announced) {}
  int rank() const override { return 0; }
  int size() const override { return 2; }
  std::vector<std::byte> exchange(Messages, const std::vector<std::int64_t>&) override {
    const std::array<std::int64_t, 2> lengths{0, announced_};
    const std::span<const std::byte> bytes = std::as_bytes(std::span(lengths));
    return {bytes.begin(), bytes.end()};
  }
  double seconds_in_exchange() const override { return 0.0; }
  std::int64_t bytes_sent() const override { return 0; }

 private:
  std::int64_t announced_;
};

/// The middle one of three: what it sends comes back as if the others had sent it.
class EchoingWorkers final : public WorkerGroup {
 public:
  int rank() const override { return 1; }
  int size() const override { return 3; }
  std::vector<std::byte> exchange(Messages sent, const std::vector<std::int64_t>& sizes) override {
    EXPECT_EQ(sent.sizes, sizes);
    EXPECT_EQ(sent.sizes[1], 0) << "its own message";
    return std::move(sent.bytes);
  }
  double seconds_in_exchange() const override { return 0.0; }
  std::int64_t bytes_sent() const override { return 0; }
};

TEST(WorkerMessages, OnesOwnGoesNowhere) {
  const auto bytes = [](std::string_view text) {
    const std::span<const std::byte> all = std::as_bytes(std::span(text));
    return std::vector<std::byte>(all.begin(), all.end());
  };
  const auto text = [](std::span<const std::byte> message) {
    return std::string(reinterpret_cast<const char*>(message.data()), message.size());
  };
  for (const auto& [first, last] : {std::pair{"ab", "cde"}, {"", "cde"}, {"ab", ""}, {"", ""}}) {
    EchoingWorkers workers;
    const auto received =
        exchanged(workers, {bytes(first), bytes("own"), bytes(last)},
                  {std::ssize(std::string_view(first)), 3, std::ssize(std::string_view(last))});
    ASSERT_EQ(received.parts.size(), 3u);
    EXPECT_EQ(text(received.parts[0]), first);
    EXPECT_EQ(text(received.parts[1]), "own");
    EXPECT_EQ(text(received.parts[2]), last);
  }
}

TEST(WorkerMessages, AMessageOfAnImpossibleSizeIsRefused) {
  for (const std::int64_t announced : {std::int64_t{-1}, (std::int64_t{1} << 40) + 1}) {
    AnnouncingWorkers workers(announced);
    EXPECT_THAT(error_of([&] {
                  exchanged(workers, {{}, {}});
                }),
                HasSubstr(fmt::format("worker 1 of 2: announces a message of {} bytes", announced)));
  }
}

TEST(WorkerMessages, ATextOfAnImpossibleSizeIsRefused) {
  for (const std::int64_t announced : {std::int64_t{-1}, (std::int64_t{1} << 30) + 1}) {
    AnnouncingWorkers workers(announced);
    EXPECT_THAT(error_of([&] { gathered(workers, ""); }),
                HasSubstr(fmt::format("worker 1 of 2: announces a message of {} bytes", announced)));
  }
}

TEST(WorkerMessages, WhoSaysSomethingElseThanWorker0IsNamed) {
  testing::ThreadWorkers workers(3);
  EXPECT_NO_THROW(workers.run([](WorkerGroup& group) { require_same(group, "other weights", "a"); }));
  EXPECT_THAT(error_of([&] {
                workers.run([](WorkerGroup& group) {
                  require_same(group, "other weights", group.rank() == 2 ? "b" : "a");
                });
              }),
              HasSubstr("worker 2 of 3 has other weights than worker 0"));
}

TEST(WorkerMessages, AMessageThatEndsEarlyIsRefused) {
  std::vector<std::byte> message;
  append_value(message, std::int32_t{7});
  MessageReader reader(message);
  EXPECT_EQ(reader.value<std::int32_t>(), 7);
  EXPECT_TRUE(reader.is_at_end());
  EXPECT_THAT(error_of([&] { reader.value<char>(); }), HasSubstr("ends early: 0 bytes are left, expected 1"));
}

}  // namespace
}  // namespace knuckle
