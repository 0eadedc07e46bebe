// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/worker_messages.h"

#include <utility>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::int64_t kLargestMessage = std::int64_t{1} << 40;

/// How long the message of each worker to this one is.
std::vector<std::int64_t> announced_sizes(WorkerGroup& workers, const std::vector<std::int64_t>& own) {
  Messages lengths;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(own));
  lengths.bytes.assign(bytes.begin(), bytes.end());
  lengths.sizes.assign(own.size(), sizeof(std::int64_t));
  const std::vector<std::int64_t> expected = lengths.sizes;
  const std::vector<std::byte> received = workers.exchange(std::move(lengths), expected);
  std::vector<std::int64_t> sizes(own.size());
  std::memcpy(sizes.data(), received.data(), received.size());
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    if (sizes[k] < 0 || sizes[k] > kLargestMessage) {
      fail("worker {} of {}: announces a message of {} bytes, expected at most {}", k, sizes.size(), sizes[k],
           kLargestMessage);
    }
  }
  return sizes;
}

/// A single message is not copied.
Messages one_after_another(OwnMessages sent) {
  Messages messages;
  std::size_t length = 0;
  for (const std::vector<std::byte>& message : sent) {
    messages.sizes.push_back(std::ssize(message));
    length += message.size();
  }
  for (std::vector<std::byte>& message : sent) {
    if (message.size() == length) {
      messages.bytes = std::move(message);
      return messages;
    }
    messages.bytes.reserve(length);
    messages.bytes.insert(messages.bytes.end(), message.begin(), message.end());
    message = {};  // its memory is wanted
  }
  return messages;
}

}  // namespace

ReceivedMessages exchanged(WorkerGroup& workers, OwnMessages sent) {
  std::vector<std::int64_t> lengths;
  for (const std::vector<std::byte>& message : sent) lengths.push_back(std::ssize(message));
  const std::vector<std::int64_t> sizes = announced_sizes(workers, lengths);
  return exchanged(workers, std::move(sent), sizes);
}

ReceivedMessages exchanged(WorkerGroup& workers, OwnMessages sent, const std::vector<std::int64_t>& sizes) {
  const auto rank = static_cast<std::size_t>(workers.rank());
  ReceivedMessages received{.bytes = {}, .own = std::exchange(sent[rank], {}), .parts = {}};
  std::vector<std::int64_t> sizes_of_others = sizes;
  sizes_of_others[rank] = 0;
  received.bytes = workers.exchange(one_after_another(std::move(sent)), sizes_of_others);
  std::span<const std::byte> left(received.bytes);
  for (const std::int64_t size : sizes_of_others) {
    received.parts.push_back(left.first(static_cast<std::size_t>(size)));
    left = left.subspan(static_cast<std::size_t>(size));
  }
  received.parts[rank] = received.own;
  return received;
}

std::span<const std::byte> MessageReader::bytes(std::size_t count) {
  if (count > left_.size()) {
    fail("a worker's message ends early: {} bytes are left, expected {}", left_.size(), count);
  }
  const std::span<const std::byte> taken = left_.first(count);
  left_ = left_.subspan(count);
  return taken;
}

}  // namespace knuckle
