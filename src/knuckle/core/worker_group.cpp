// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/worker_group.h"

#include <cstring>
#include <span>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::int64_t kLargestText = std::int64_t{1} << 30;

/// The same bytes for everybody.
Messages to_all(int workers, std::span<const std::byte> text) {
  Messages messages;
  for (int k = 0; k < workers; ++k) {
    messages.bytes.insert(messages.bytes.end(), text.begin(), text.end());
    messages.sizes.push_back(std::ssize(text));
  }
  return messages;
}

std::vector<std::int64_t> sizes_of_all(WorkerGroup& workers, std::int64_t own) {
  const auto count = static_cast<std::size_t>(workers.size());
  const std::vector<std::byte> received =
      workers.exchange(to_all(workers.size(), std::as_bytes(std::span(&own, 1))),
                       std::vector<std::int64_t>(count, sizeof(std::int64_t)));
  std::vector<std::int64_t> sizes(count);
  std::memcpy(sizes.data(), received.data(), received.size());
  for (std::size_t k = 0; k < count; ++k) {
    if (sizes[k] < 0 || sizes[k] > kLargestText) {
      fail("worker {} of {}: announces a message of {} bytes, expected at most {}", k, count, sizes[k],
           kLargestText);
    }
  }
  return sizes;
}

std::vector<std::string> texts_in(const std::vector<std::byte>& received,
                                  const std::vector<std::int64_t>& sizes) {
  std::vector<std::string> texts;
  const auto* next = reinterpret_cast<const char*>(received.data());
  for (const std::int64_t size : sizes) {
    texts.emplace_back(next, static_cast<std::size_t>(size));
    next += size;
  }
  return texts;
}

}  // namespace

std::vector<std::string> gathered(WorkerGroup& workers, std::string_view own) {
  const std::vector<std::int64_t> sizes = sizes_of_all(workers, std::ssize(own));
  return texts_in(workers.exchange(to_all(workers.size(), std::as_bytes(std::span(own))), sizes), sizes);
}

std::string from_first(WorkerGroup& workers, std::string_view own) {
  const std::string_view said = workers.rank() == 0 ? own : std::string_view();
  return gathered(workers, said).front();
}

void require_same(WorkerGroup& workers, std::string_view what, std::string_view own) {
  const std::vector<std::string> all = gathered(workers, own);
  for (std::size_t k = 1; k < all.size(); ++k) {
    if (all[k] != all[0]) fail("worker {} of {} has {} than worker 0", k, all.size(), what);
  }
}

PartOfWork part_of_worker(std::int64_t count, int rank, int size) {
  return {count * rank / size, count * (rank + 1) / size};
}

}  // namespace knuckle
