// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/shard_sum.h"

#include <cstring>
#include <utility>

#include <torch/utils.h>

#include "knuckle/core/parallel.h"
#include "knuckle/training/torch_threads.h"

namespace knuckle {
namespace {

constexpr std::int64_t kFloat = sizeof(float);
/// A loss travels among the numbers as the two of its bits.
constexpr std::int64_t kNumbersPerLoss = sizeof(double) / sizeof(float);

/// Tensors as bytes, through the processor's memory.
class ByteExchange final : public TensorExchange {
 public:
  explicit ByteExchange(WorkerGroup& workers) : workers_(workers) {}

  torch::Tensor exchange(const torch::Tensor& sent, std::vector<std::int64_t> sent_counts,
                         std::vector<std::int64_t> received_counts) override {
    for (std::int64_t& count : sent_counts) count *= kFloat;
    for (std::int64_t& count : received_counts) count *= kFloat;
    const torch::Tensor numbers = sent.cpu().contiguous();
    const auto* const first = static_cast<const std::byte*>(numbers.data_ptr());
    std::vector<std::byte> received =
        workers_.exchange({{first, first + numbers.nbytes()}, std::move(sent_counts)}, received_counts);
    const auto kept = std::make_shared<std::vector<std::byte>>(std::move(received));
    const std::int64_t count = std::ssize(*kept) / kFloat;
    return torch::from_blob(
               kept->data(), {count}, [kept](void*) {}, torch::kFloat)
        .to(sent.device());
  }

 private:
  WorkerGroup& workers_;
};

std::unique_ptr<TensorExchange> exchange_of(WorkerGroup& workers, const torch::Device& device) {
  std::unique_ptr<TensorExchange> exchange;
  if (auto* const own = dynamic_cast<DeviceWorkers*>(&workers)) exchange = own->exchange_on(device);
  return exchange ? std::move(exchange) : std::make_unique<ByteExchange>(workers);
}

/// All numbers of a list, one tensor after another; where they lie so, they are not copied.
torch::Tensor flat(const std::vector<torch::Tensor>& tensors) {
  if (tensors.size() == 1 && tensors.front().is_contiguous()) return tensors.front().view({-1});
  std::int64_t length = 0;
  for (const torch::Tensor& tensor : tensors) length += tensor.numel();
  torch::Tensor values = torch::empty({length}, tensors.front().options());
  std::int64_t next = 0;
  for (const torch::Tensor& tensor : tensors) {
    values.narrow(0, next, tensor.numel()).view(tensor.sizes()).copy_(tensor);
    next += tensor.numel();
  }
  return values;
}

void set_from_flat(const torch::Tensor& values, const std::vector<torch::Tensor>& tensors) {
  std::int64_t next = 0;
  for (const torch::Tensor& tensor : tensors) {
    tensor.copy_(values.narrow(0, next, tensor.numel()).view(tensor.sizes()));
    next += tensor.numel();
  }
}

torch::Tensor numbers_of(std::span<const double> losses) {
  torch::Tensor numbers = torch::empty({std::ssize(losses) * kNumbersPerLoss});
  std::memcpy(numbers.data_ptr(), losses.data(), losses.size_bytes());
  return numbers;
}

void set_losses(std::span<double> losses, const torch::Tensor& numbers) {
  const torch::Tensor here = numbers.cpu().contiguous();
  std::memcpy(losses.data(), here.data_ptr(), losses.size_bytes());
}

}  // namespace

ShardSum::ShardSum(WorkerGroup& workers, int shards, const torch::Device& device)
    : workers_(workers), shards_(shards), exchange_(exchange_of(workers, device)) {}

std::vector<double> ShardSum::sum(const std::vector<std::vector<torch::Tensor>>& own,
                                  std::span<const double> losses) {
  const torch::NoGradGuard no_gradient;
  std::vector<torch::Tensor> values(own.size());
  parallel_for(std::ssize(own), [&](std::int64_t i) {
    use_calling_thread_alone();
    const torch::NoGradGuard none_here;
    const auto shard = static_cast<std::size_t>(i);
    values[shard] = flat(own[shard]);
  });
  torch::Tensor whole;
  std::vector<double> all_losses = share(summed_part(values), losses, values.front().numel(), whole);
  set_from_flat(whole, own.front());
  return all_losses;
}

/// The sums of this worker's part of the numbers.
torch::Tensor ShardSum::summed_part(const std::vector<torch::Tensor>& own) {
  const int workers = workers_.size();
  const std::int64_t length = own.front().numel();
  const std::int64_t mine = part_of_worker(length, workers_.rank(), workers).size();
  std::vector<torch::Tensor> sent;
  std::vector<std::int64_t> sent_counts;
  std::vector<std::int64_t> received_counts;
  for (int worker = 0; worker < workers; ++worker) {
    const PartOfWork part = part_of_worker(length, worker, workers);
    for (const torch::Tensor& shard : own) sent.push_back(shard.narrow(0, part.begin, part.size()));
    sent_counts.push_back(std::ssize(own) * part.size());
    received_counts.push_back(shards_of(worker).size() * mine);
  }
  const torch::Tensor all = own.size() == 1 ? own.front() : torch::cat(sent);
  const torch::Tensor received = exchange_->exchange(all, std::move(sent_counts), std::move(received_counts));
  torch::Tensor sum = received.narrow(0, 0, mine);
  for (int shard = 1; shard < shards_; ++shard) sum.add_(received.narrow(0, shard * mine, mine));
  return sum;
}

/// Puts the parts of all workers together as `whole`, of that length, and returns the losses of all shards.
std::vector<double> ShardSum::share(const torch::Tensor& part, std::span<const double> losses,
                                    std::int64_t length, torch::Tensor& whole) {
  const int workers = workers_.size();
  const std::int64_t numbers_per_loss = losses.empty() ? 0 : kNumbersPerLoss;
  const torch::Tensor own = losses.empty() ? part : torch::cat({part, numbers_of(losses).to(part.device())});
  std::vector<std::int64_t> received_counts;
  for (int worker = 0; worker < workers; ++worker) {
    received_counts.push_back(part_of_worker(length, worker, workers).size() +
                              shards_of(worker).size() * numbers_per_loss);
  }
  const torch::Tensor received = exchange_->exchange(
      own.repeat({workers}), std::vector<std::int64_t>(static_cast<std::size_t>(workers), own.numel()),
      std::move(received_counts));
  if (losses.empty()) {
    whole = received;
    return {};
  }
  whole = torch::empty({length}, part.options());
  std::vector<double> all_losses(static_cast<std::size_t>(shards_));
  std::int64_t next = 0;
  const auto taken = [&](std::int64_t count) {
    next += count;
    return received.narrow(0, next - count, count);
  };
  for (int worker = 0; worker < workers; ++worker) {
    const PartOfWork numbers = part_of_worker(length, worker, workers);
    const PartOfWork shards = shards_of(worker);
    whole.narrow(0, numbers.begin, numbers.size()).copy_(taken(numbers.size()));
    set_losses(std::span(all_losses)
                   .subspan(static_cast<std::size_t>(shards.begin), static_cast<std::size_t>(shards.size())),
               taken(shards.size() * kNumbersPerLoss));
  }
  return all_losses;
}

}  // namespace knuckle
