// SPDX-License-Identifier: Apache-2.0
#include "knuckle/workers/nccl_exchange.h"

#include <chrono>
#include <cstdlib>
#include <numeric>
#include <thread>
#include <utility>

#include <ATen/Functions.h>
#include <torch/csrc/distributed/c10d/PrefixStore.hpp>
#include <torch/csrc/distributed/c10d/ProcessGroupNCCL.hpp>

#include "knuckle/pipeline/stopwatch.h"

namespace knuckle {
namespace {

using Nccl = c10d::ProcessGroupNCCL;

/// Between two looks whether a sum is done: it takes a tenth of a millisecond, or waits for another worker.
constexpr auto kLookAtGpu = std::chrono::microseconds(20);

/// A worker that is lost is told of by those that are left, in one line: c10d would end the process.
void leave_faults_to_us() {
  for (const char* const name : {"TORCH_NCCL_ASYNC_ERROR_HANDLING", "NCCL_ASYNC_ERROR_HANDLING"})
    ::setenv(name, "0", 0);
}

c10::intrusive_ptr<Nccl> group_of(C10dWorkers& workers) {
  leave_faults_to_us();
  const auto options = Nccl::Options::create();
  options->timeout = kNoTimeLimit;
  const auto store = c10::make_intrusive<c10d::PrefixStore>("nccl", workers.store());
  return c10::make_intrusive<Nccl>(store, workers.rank(), workers.size(), options);
}

class NcclExchange final : public TensorExchange {
 public:
  explicit NcclExchange(C10dWorkers& workers) : workers_(workers), group_(group_of(workers)) {}

  ~NcclExchange() override {
    // Its threads may wait for messages that never come.
    if (is_broken_) group_.release();
  }

  torch::Tensor exchange(const torch::Tensor& sent, std::vector<std::int64_t> sent_counts,
                         std::vector<std::int64_t> received_counts) override {
    workers_.end_if_over();
    const Stopwatch watch;
    torch::Tensor input = sent.contiguous();
    torch::Tensor output = at::empty(
        {std::reduce(received_counts.begin(), received_counts.end(), std::int64_t{0})}, sent.options());
    const std::int64_t others = input.numel() - sent_counts[static_cast<std::size_t>(workers_.rank())];
    try {
      wait_for(*group_->alltoall_base(output, input, received_counts, sent_counts));
    } catch (const std::exception& error) {
      is_broken_ = true;
      throw workers_.fault_of_exchange(error.what());
    }
    workers_.add_exchange(watch.seconds(), others * static_cast<std::int64_t>(sizeof(float)));
    return output;
  }

 private:
  /// Until it is done on the GPU, so that a worker that is lost is noticed meanwhile.
  void wait_for(c10d::Work& work) {
    while (!work.isCompleted()) {
      workers_.end_if_over();
      std::this_thread::sleep_for(kLookAtGpu);
    }
    work.wait();  // throws what has gone wrong
  }

  C10dWorkers& workers_;
  c10::intrusive_ptr<Nccl> group_;
  bool is_broken_ = false;
};

}  // namespace

std::unique_ptr<TensorExchange> nccl_exchange(C10dWorkers& workers, const torch::Device& device) {
  if (!device.is_cuda()) return nullptr;
  return std::make_unique<NcclExchange>(workers);
}

}  // namespace knuckle
