// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/shard_sum.h"

#include <cstring>

#include <torch/utils.h>

#include "knuckle/core/parallel.h"
#include "knuckle/training/torch_threads.h"

namespace knuckle {
namespace {

constexpr std::int64_t kFloat = sizeof(float);
constexpr std::int64_t kDouble = sizeof(double);

/// All numbers of a list, one tensor after another.
std::vector<float> flat(const std::vector<torch::Tensor>& tensors) {
  std::int64_t length = 0;
  for (const torch::Tensor& tensor : tensors) length += tensor.numel();
  std::vector<float> values(static_cast<std::size_t>(length));
  float* next = values.data();
  for (const torch::Tensor& tensor : tensors) {
    torch::from_blob(next, tensor.sizes()).copy_(tensor);
    next += tensor.numel();
  }
  return values;
}

void set_from_flat(std::vector<float>& values, const std::vector<torch::Tensor>& tensors) {
  float* next = values.data();
  for (const torch::Tensor& tensor : tensors) {
    tensor.copy_(torch::from_blob(next, tensor.sizes()));
    next += tensor.numel();
  }
}

void append(Messages& messages, const void* from, std::int64_t size) {
  const auto* const bytes = static_cast<const std::byte*>(from);
  messages.bytes.insert(messages.bytes.end(), bytes, bytes + size);
}

}  // namespace

std::vector<double> ShardSum::sum(const std::vector<std::vector<torch::Tensor>>& own,
                                  std::span<const double> losses) {
  std::vector<std::vector<float>> values(own.size());
  parallel_for(std::ssize(own), [&](std::int64_t i) {
    use_calling_thread_alone();
    const torch::NoGradGuard no_gradient;
    const auto shard = static_cast<std::size_t>(i);
    values[shard] = flat(own[shard]);
  });
  std::vector<float> whole = std::move(values.front());
  values.front() = whole;
  const std::vector<float> part = summed_part(values, std::ssize(whole));
  std::vector<double> all_losses = share(part, losses, whole);
  set_from_flat(whole, own.front());
  return all_losses;
}

/// The sums of this worker's part of the numbers.
std::vector<float> ShardSum::summed_part(const std::vector<std::vector<float>>& own, std::int64_t length) {
  const int count = workers_.size();
  const PartOfWork mine = part_of_worker(length, workers_.rank(), count);
  Messages sent;
  sent.bytes.reserve(static_cast<std::size_t>(std::ssize(own) * length * kFloat));
  std::vector<std::int64_t> sizes;
  for (int worker = 0; worker < count; ++worker) {
    const PartOfWork part = part_of_worker(length, worker, count);
    for (const std::vector<float>& shard : own) append(sent, shard.data() + part.begin, part.size() * kFloat);
    sent.sizes.push_back(std::ssize(own) * part.size() * kFloat);
    sizes.push_back(shards_of(worker).size() * mine.size() * kFloat);
  }
  const std::vector<std::byte> received = workers_.exchange(std::move(sent), sizes);
  std::vector<float> sum(static_cast<std::size_t>(mine.size()));
  std::vector<float> term(sum.size());
  const std::size_t bytes = sum.size() * sizeof(float);
  std::memcpy(sum.data(), received.data(), bytes);
  for (std::size_t shard = 1; shard < static_cast<std::size_t>(shards_); ++shard) {
    std::memcpy(term.data(), received.data() + shard * bytes, bytes);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += term[i];
  }
  return sum;
}

/// Puts the parts of all workers together as `whole`, and returns the losses of all shards.
std::vector<double> ShardSum::share(const std::vector<float>& part, std::span<const double> losses,
                                    std::vector<float>& whole) {
  const int count = workers_.size();
  Messages sent;
  std::vector<std::int64_t> sizes;
  for (int worker = 0; worker < count; ++worker) {
    append(sent, part.data(), std::ssize(part) * kFloat);
    append(sent, losses.data(), std::ssize(losses) * kDouble);
    sent.sizes.push_back(std::ssize(part) * kFloat + std::ssize(losses) * kDouble);
    sizes.push_back(part_of_worker(std::ssize(whole), worker, count).size() * kFloat +
                    shards_of(worker).size() * kDouble);
  }
  const std::vector<std::byte> received = workers_.exchange(std::move(sent), sizes);
  std::vector<double> all_losses(static_cast<std::size_t>(shards_));
  const std::byte* next = received.data();
  for (int worker = 0; worker < count; ++worker) {
    const PartOfWork numbers = part_of_worker(std::ssize(whole), worker, count);
    const PartOfWork shards = shards_of(worker);
    std::memcpy(whole.data() + numbers.begin, next, static_cast<std::size_t>(numbers.size() * kFloat));
    next += numbers.size() * kFloat;
    std::memcpy(all_losses.data() + shards.begin, next, static_cast<std::size_t>(shards.size() * kDouble));
    next += shards.size() * kDouble;
  }
  return all_losses;
}

}  // namespace knuckle
