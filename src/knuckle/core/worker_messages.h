// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "knuckle/core/worker_group.h"

namespace knuckle {

/// A message to each worker, in their order.
using OwnMessages = std::vector<std::vector<std::byte>>;

/// What each worker has sent to this one.
struct ReceivedMessages {
  std::vector<std::byte> bytes;                   ///< those of the others, one after another
  std::vector<std::byte> own;                     ///< what this one has sent to itself: it goes nowhere
  std::vector<std::span<const std::byte>> parts;  ///< one per worker, in their order
};

/// Sends message k to worker k, this one included, and returns what all have sent to this one. Their lengths
/// are told first. Throws an Error where a worker announces more than 2^40 bytes.
ReceivedMessages exchanged(WorkerGroup& workers, OwnMessages sent);

/// The same where it is known how many bytes each worker sends to this one.
ReceivedMessages exchanged(WorkerGroup& workers, OwnMessages sent, const std::vector<std::int64_t>& sizes);

/// Appends a value's bytes.
template <class T>
void append_value(std::vector<std::byte>& message, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
  message.insert(message.end(), bytes, bytes + sizeof(T));
}

/// Appends the bytes of many.
template <class T>
void append_values(std::vector<std::byte>& message, std::span<const T> values) {
  const std::span<const std::byte> bytes = std::as_bytes(values);
  message.insert(message.end(), bytes.begin(), bytes.end());
}

/// Takes a message apart. Throws an Error where it is shorter than what is asked for.
class MessageReader {
 public:
  explicit MessageReader(std::span<const std::byte> message) : left_(message) {}

  template <class T>
  T value() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    std::memcpy(&value, bytes(sizeof(T)).data(), sizeof(T));
    return value;
  }
  template <class T>
  void read(std::span<T> values) {
    const std::span<const std::byte> from = bytes(values.size_bytes());
    if (!values.empty()) std::memcpy(values.data(), from.data(), from.size());
  }
  std::span<const std::byte> bytes(std::size_t count);
  bool is_at_end() const { return left_.empty(); }
  std::size_t bytes_left() const { return left_.size(); }

 private:
  std::span<const std::byte> left_;
};

/// One value of each worker, in their order.
template <class T>
std::vector<T> values_of_all(WorkerGroup& workers, const T& own) {
  const auto count = static_cast<std::size_t>(workers.size());
  Messages messages;
  for (std::size_t k = 0; k < count; ++k) append_value(messages.bytes, own);
  messages.sizes.assign(count, sizeof(T));
  const std::vector<std::int64_t> expected = messages.sizes;
  const std::vector<std::byte> received = workers.exchange(std::move(messages), expected);
  std::vector<T> values(count);
  std::memcpy(values.data(), received.data(), received.size());
  return values;
}

}  // namespace knuckle
