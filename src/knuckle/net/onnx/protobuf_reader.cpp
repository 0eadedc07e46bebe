// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/onnx/protobuf_reader.h"

#include <bit>
#include <cstring>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::uint64_t kMostFieldNumber = (std::uint64_t{1} << 29) - 1;
constexpr int kMostVarintBytes = 10;

}  // namespace

std::optional<ProtobufField> ProtobufReader::next() {
  if (rest_.empty()) return std::nullopt;
  const std::uint64_t tag = varint();
  ProtobufField field;
  if (tag >> 3 == 0 || tag >> 3 > kMostFieldNumber)
    fail("{}: damaged, a field has the number {}", what_, tag >> 3);
  field.number = static_cast<std::uint32_t>(tag >> 3);
  switch (tag & 7) {
    case 0:
      field.value = varint();
      break;
    case 1:
      field.kind = ProtobufField::Kind::fixed64;
      field.value = fixed(sizeof(std::uint64_t));
      break;
    case 2:
      field.kind = ProtobufField::Kind::bytes;
      field.bytes = take(varint());
      break;
    case 5:
      field.kind = ProtobufField::Kind::fixed32;
      field.value = fixed(sizeof(std::uint32_t));
      break;
    default:
      fail("{}: damaged, field {} is of the unknown type {}", what_, field.number, tag & 7);
  }
  return field;
}

void ProtobufReader::require_once(const ProtobufField& field) {
  const std::uint64_t bit = std::uint64_t{1} << (field.number & 63);
  if ((seen_ & bit) != 0) fail_at(field, "is there twice");
  seen_ |= bit;
}

void ProtobufReader::fail_at(const ProtobufField& field, std::string_view fault) const {
  fail("{}: field {} {}", what_, field.number, fault);
}

std::string_view ProtobufReader::bytes_of(const ProtobufField& field) const {
  if (field.kind != ProtobufField::Kind::bytes) fail_at(field, "is damaged, expected bytes");
  return field.bytes;
}

std::int64_t ProtobufReader::integer_of(const ProtobufField& field) const {
  if (field.kind != ProtobufField::Kind::varint) fail_at(field, "is damaged, expected a whole number");
  return static_cast<std::int64_t>(field.value);
}

float ProtobufReader::real_of(const ProtobufField& field) const {
  if (field.kind != ProtobufField::Kind::fixed32) fail_at(field, "is damaged, expected a number");
  return std::bit_cast<float>(static_cast<std::uint32_t>(field.value));
}

void ProtobufReader::add_integers(const ProtobufField& field, std::vector<std::int64_t>& numbers) const {
  const auto add = [&](std::int64_t number) {
    if (numbers.size() == kMostIntegers) {
      fail_at(field, fmt::format("is a list of more than {} whole numbers", kMostIntegers));
    }
    numbers.push_back(number);
  };
  if (field.kind != ProtobufField::Kind::bytes) return add(integer_of(field));
  ProtobufReader packed(field.bytes, what_);
  while (!packed.rest_.empty()) add(static_cast<std::int64_t>(packed.varint()));
}

void ProtobufReader::add_reals(const ProtobufField& field, std::vector<float>& numbers) const {
  if (field.kind != ProtobufField::Kind::bytes) {
    numbers.push_back(real_of(field));
    return;
  }
  if (field.bytes.size() % sizeof(float) != 0)
    fail_at(field, "is damaged, expected whole numbers of 4 bytes");
  const std::size_t before = numbers.size();
  numbers.resize(before + field.bytes.size() / sizeof(float));
  if (field.bytes.empty()) return;
  std::memcpy(numbers.data() + before, field.bytes.data(), field.bytes.size());
}

std::uint64_t ProtobufReader::varint() {
  std::uint64_t value = 0;
  for (int i = 0; i < kMostVarintBytes; ++i) {
    const auto byte = static_cast<std::uint8_t>(take(1).front());
    if (i + 1 == kMostVarintBytes && byte > 1) break;  // more than 64 bits
    value |= static_cast<std::uint64_t>(byte & 0x7F) << (7 * i);
    if (byte < 0x80) return value;
  }
  fail("{}: damaged, a whole number has more than 64 bits", what_);
}

std::uint64_t ProtobufReader::fixed(std::size_t size) {
  const std::string_view bytes = take(size);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    value |= static_cast<std::uint64_t>(static_cast<std::uint8_t>(bytes[i])) << (8 * i);
  }
  return value;
}

std::string_view ProtobufReader::take(std::uint64_t size) {
  if (size > rest_.size()) fail_short();
  const std::string_view bytes = rest_.substr(0, static_cast<std::size_t>(size));
  rest_.remove_prefix(static_cast<std::size_t>(size));
  return bytes;
}

void ProtobufReader::fail_short() const {
  fail("{}: damaged or cut short, a field is longer than what is left", what_);
}

}  // namespace knuckle
