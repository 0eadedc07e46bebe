// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/packed_row.h"

#include <array>
#include <bit>
#include <cstring>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::size_t kEight = 8;
constexpr std::size_t kEightsPerByte = 8;

/// Eight values as two words.
using Eight = std::array<std::uint64_t, 2>;

Eight eight_of(std::int16_t value) {
  const std::uint64_t word = static_cast<std::uint16_t>(value) * std::uint64_t{0x0001000100010001};
  return {word, word};
}

Eight eight_at(const std::int16_t* values) {
  Eight eight;
  std::memcpy(&eight, values, sizeof eight);
  return eight;
}

std::size_t mask_bytes(std::size_t eights) {
  return (eights + kEightsPerByte - 1) / kEightsPerByte;
}

}  // namespace

std::size_t packed_bytes(std::span<const std::int16_t> row) {
  const std::size_t eights = row.size() / kEight;
  const Eight background = eight_of(row.front());
  std::size_t kept = row.size() % kEight;
  for (std::size_t i = 0; i < eights; ++i) {
    kept += eight_at(row.data() + i * kEight) == background ? 0 : kEight;
  }
  return sizeof(std::int16_t) * (1 + kept) + mask_bytes(eights);
}

void append_packed(std::vector<std::byte>& message, std::span<const std::int16_t> row) {
  const std::size_t eights = row.size() / kEight;
  const Eight background = eight_of(row.front());
  append_value(message, row.front());
  const std::size_t mask = message.size();
  message.resize(mask + mask_bytes(eights));
  for (std::size_t i = 0; i < eights; ++i) {
    const Eight eight = eight_at(row.data() + i * kEight);
    if (eight == background) continue;
    message[mask + i / kEightsPerByte] |= std::byte{1} << (i % kEightsPerByte);
    append_value(message, eight);
  }
  append_values(message, row.subspan(eights * kEight));
}

void read_packed(MessageReader& reader, std::span<std::int16_t> row) {
  const std::size_t eights = row.size() / kEight;
  const Eight background = eight_of(reader.value<std::int16_t>());
  const std::span<const std::byte> mask = reader.bytes(mask_bytes(eights));
  if (eights % kEightsPerByte != 0 && mask.back() >> (eights % kEightsPerByte) != std::byte{0})
    fail("a worker's message: a row of {} features has values beyond", row.size());
  std::size_t kept = 0;
  for (const std::byte bits : mask)
    kept += static_cast<std::size_t>(std::popcount(std::to_integer<unsigned>(bits)));
  const std::span<const std::byte> values = reader.bytes(kept * sizeof(Eight));
  const std::byte* next = values.data();
  for (std::size_t i = 0; i < eights; ++i) {
    const bool is_kept = (mask[i / kEightsPerByte] & (std::byte{1} << (i % kEightsPerByte))) != std::byte{0};
    std::memcpy(row.data() + i * kEight, is_kept ? static_cast<const void*>(next) : &background,
                sizeof(Eight));
    if (is_kept) next += sizeof(Eight);
  }
  reader.read(row.subspan(eights * kEight));
}

}  // namespace knuckle
