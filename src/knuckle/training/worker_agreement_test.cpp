// SPDX-License-Identifier: Apache-2.0
// Workers that do not have what worker 0 has are refused before they add to its gradients.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/testing.h"
#include "knuckle/core/worker_group.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/training/network_training.h"
#include "knuckle/training/training_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::made_up_samples;
using testing::short_training;
using testing::small_network;

/// Worker 0 of two, whose other worker says what it says itself, but for one bit of one message.
class MirroredWorker final : public WorkerGroup {
 public:
  /// `changed`: the number of that message, from 0 on; none where it is negative.
  explicit MirroredWorker(int changed) : changed_(changed) {}

  int rank() const override { return 0; }
  int size() const override { return 2; }
  std::vector<std::byte> exchange(Messages sent, const std::vector<std::int64_t>& sizes) override {
    const std::span<const std::byte> own(sent.bytes.data(), static_cast<std::size_t>(sent.sizes[0]));
    EXPECT_EQ(sizes, std::vector<std::int64_t>(2, std::ssize(own)));
    std::vector<std::byte> received(own.begin(), own.end());
    received.insert(received.end(), own.begin(), own.end());
    if (count_++ == changed_) received.back() ^= std::byte{1};
    return received;
  }
  double seconds_in_exchange() const override { return 0.0; }
  std::int64_t bytes_sent() const override { return 0; }
  int count() const { return count_; }

 private:
  int changed_;
  int count_ = 0;
};

class WorkerAgreement : public ::testing::Test {
 protected:
  void train(MirroredWorker& workers) const {
    NetworkTrainingRun run = testing::run_in(folder_.path(), "net");
    run.workers = &workers;
    train_network(small_network(), short_training(), {}, {TrainingCrops{training_}}, validation_, run);
  }
  std::string fault_of(int changed) const {
    MirroredWorker workers(changed);
    return error_of([&] { train(workers); });
  }

 private:
  testing::TemporaryFolder folder_;
  CubeSamples training_ = made_up_samples(8);
  CubeSamples validation_ = made_up_samples(3);
};

/// Each of them says how long its text is, then the text.
TEST_F(WorkerAgreement, IsAskedForBeforeTheFirstStep) {
  const auto than_worker_0 = [](const std::string& what) {
    return HasSubstr("worker 1 of 2 has " + what + " than worker 0");
  };
  EXPECT_THAT(fault_of(1), than_worker_0("other options or another number of samples"));
  EXPECT_THAT(fault_of(3), than_worker_0("another checkpoint"));
  EXPECT_THAT(fault_of(5), than_worker_0("other samples"));
  EXPECT_THAT(fault_of(7), than_worker_0("other weights"));
}

TEST_F(WorkerAgreement, IsAskedForAtEachValidation) {
  MirroredWorker same(-1);
  EXPECT_NO_THROW(train(same));
  // The last messages are of the second validation: two of the weights, then two of its metrics.
  EXPECT_THAT(fault_of(same.count() - 3), HasSubstr("worker 1 of 2 has other weights than worker 0"));
}

}  // namespace
}  // namespace knuckle
