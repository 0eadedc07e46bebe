// SPDX-License-Identifier: Apache-2.0
// What one object must do for many threads at once. The thread sanitizer watches these tests (preset `tsan`).
#include <mutex>
#include <thread>
#include <vector>

#include "knuckle/core/resources.h"
#include "knuckle/core/testing.h"
#include "knuckle/data/frame_stream.h"
#include "knuckle/pipeline/estimate_each.h"
#include "knuckle/pipeline/pipeline.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle {
namespace {

constexpr int kSharingThreads = 4;
constexpr std::int64_t kSharedFrames = 6;

/// The joints of all hands in a frame: u, v and depth of one after another.
std::vector<double> joints_of(const FrameEstimate& estimate) {
  std::vector<double> numbers;
  for (const HandEstimate& hand : estimate.hands) {
    for (const ImagePoint& joint : hand.pose.joints)
      numbers.insert(numbers.end(), {joint.u, joint.v, joint.depth_mm});
  }
  return numbers;
}

std::unique_ptr<FrameSource> shared_frames() {
  return open_source("synthetic:" + resource_path("manifests/demo.toml").string() +
                     fmt::format("?first=0&count={}", kSharedFrames));
}

class SharingTest : public ::testing::TestWithParam<const char*> {
 protected:
  const Pipeline pipeline_ = Pipeline::load(resource_path(std::string("pipelines/") + GetParam()));
  const std::unique_ptr<FrameSource> source_ = shared_frames();
};

TEST_P(SharingTest, OnePipelineAndOneSourceGiveEveryThreadWhatTheyGiveOne) {
  std::vector<std::vector<double>> alone;
  for (std::int64_t i = 0; i < kSharedFrames; ++i) {
    alone.push_back(joints_of(pipeline_.estimate(source_->read(i))));
    EXPECT_FALSE(alone.back().empty()) << "frame " << i;
  }
  std::vector<std::vector<std::vector<double>>> shared(kSharingThreads);
  {
    std::vector<std::jthread> threads;
    for (auto& own : shared) {
      threads.emplace_back([&] {
        for (std::int64_t i = 0; i < kSharedFrames; ++i)
          own.push_back(joints_of(pipeline_.estimate(source_->read(i))));
      });
    }
  }
  for (const auto& own : shared) EXPECT_EQ(own, alone);
}

TEST_P(SharingTest, OneRunningStreamFeedsManyThreads) {
  SourceStream stream(*source_);
  std::mutex turn;  // a stream has one reader at a time
  std::int64_t found = 0;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < kSharingThreads; ++t) {
      threads.emplace_back([&] {
        while (true) {
          std::unique_lock lock(turn);
          const auto frame = stream.next();
          lock.unlock();
          if (!frame) return;
          const bool is_found = !pipeline_.estimate(*frame).hands.empty();
          lock.lock();
          found += is_found ? 1 : 0;
        }
      });
    }
  }
  EXPECT_EQ(found, kSharedFrames);
}

INSTANTIATE_TEST_SUITE_P(Pipelines, SharingTest,
                         ::testing::Values("default.toml", "careful.toml", "free_hand.toml",
                                           "pose_forest.toml"),
                         [](const auto& tested) {
                           const std::string file = tested.param;
                           return file.substr(0, file.find('.'));
                         });

}  // namespace
}  // namespace knuckle
