// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_number.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace knuckle {
namespace {

// Classes of types.
constexpr unsigned kInteger = 0;
constexpr unsigned kFloating = 1;
constexpr unsigned kText = 3;
constexpr unsigned kVariableLength = 9;

/// Where sign, exponent and mantissa lie in IEEE 754's numbers of 4 and 8 bytes.
bool is_ieee(Hdf5Cursor& properties, unsigned sign_place, std::size_t bytes) {
  const unsigned first_bit = properties.u16();
  const unsigned bits = properties.u16();
  const unsigned exponent_place = properties.u8();
  const unsigned exponent_bits = properties.u8();
  const unsigned mantissa_place = properties.u8();
  const unsigned mantissa_bits = properties.u8();
  const std::uint32_t bias = properties.u32();
  if (first_bit != 0 || mantissa_place != 0) return false;
  if (bytes == 4) {
    return bits == 32 && sign_place == 31 && exponent_place == 23 && exponent_bits == 8 &&
           mantissa_bits == 23 && bias == 127;
  }
  return bytes == 8 && bits == 64 && sign_place == 63 && exponent_place == 52 && exponent_bits == 11 &&
         mantissa_bits == 52 && bias == 1023;
}

bool is_whole_integer(Hdf5Cursor& properties, std::size_t bytes) {
  const unsigned first_bit = properties.u16();
  const unsigned bits = properties.u16();
  return first_bit == 0 && bits == 8 * bytes && (bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8);
}

template <class From>
From stored_number(const std::uint8_t* bytes, bool is_big_endian) {
  std::uint8_t ordered[sizeof(From)];
  std::memcpy(ordered, bytes, sizeof(From));
  if (is_big_endian) std::reverse(ordered, ordered + sizeof(From));
  From value;
  std::memcpy(&value, ordered, sizeof(From));
  return value;
}

template <class To, class From>
bool fits(From value) {
  if constexpr (std::is_floating_point_v<To>) {
    if constexpr (sizeof(From) > sizeof(To) && std::is_floating_point_v<From>) {
      return !std::isfinite(value) || std::abs(value) <= static_cast<From>(std::numeric_limits<To>::max());
    }
    return true;
  } else if constexpr (std::is_floating_point_v<From>) {
    const From end = std::ldexp(From{1}, std::numeric_limits<To>::digits);  // exactly; max() may not be
    const From begin = std::is_signed_v<To> ? -end : From{0};
    return value >= begin && value < end && std::trunc(value) == value;
  } else {
    return std::in_range<To>(value);
  }
}

template <class From, class To>
std::string convert_from(std::span<const std::uint8_t> stored, bool is_big_endian, std::span<To> to) {
  for (std::size_t i = 0; i < to.size(); ++i) {
    const From value = stored_number<From>(stored.data() + i * sizeof(From), is_big_endian);
    if (!fits<To>(value)) return fmt::format("{}", value);
    to[i] = static_cast<To>(value);  // NOLINT(bugprone-signed-char-misuse): these are numbers
  }
  return {};
}

template <class Integer1, class Integer2, class Integer4, class Integer8, class To>
std::string convert_from_integers(const Hdf5Number& type, std::span<const std::uint8_t> stored,
                                  std::span<To> to) {
  if (type.bytes == 1) return convert_from<Integer1>(stored, type.is_big_endian, to);
  if (type.bytes == 2) return convert_from<Integer2>(stored, type.is_big_endian, to);
  if (type.bytes == 4) return convert_from<Integer4>(stored, type.is_big_endian, to);
  return convert_from<Integer8>(stored, type.is_big_endian, to);
}

}  // namespace

Hdf5Type read_type(Hdf5Cursor cursor) {
  const unsigned class_and_version = cursor.u8();
  const unsigned flags = static_cast<unsigned>(cursor.number(3));
  Hdf5Type type;
  type.bytes = cursor.u32();
  type.number.bytes = type.bytes;
  type.number.is_big_endian = (flags & 0x01U) != 0;
  bool is_number = false;
  switch (class_and_version & 0x0fU) {
    case kInteger:
      type.number.kind =
          (flags & 0x08U) != 0 ? Hdf5Number::Kind::signed_integer : Hdf5Number::Kind::unsigned_integer;
      is_number = is_whole_integer(cursor, type.bytes);
      break;
    case kFloating: {
      constexpr unsigned kVaxOrder = 0x40;
      type.number.kind = Hdf5Number::Kind::floating;
      is_number = (flags & kVaxOrder) == 0 && is_ieee(cursor, flags >> 8 & 0xffU, type.bytes);
      break;
    }
    case kText:
      type.kind = Hdf5Type::Kind::text;
      break;
    case kVariableLength:
      type.kind = Hdf5Type::Kind::variable_text;
      break;
    default:
      break;
  }
  if (is_number) type.kind = Hdf5Type::Kind::number;
  return type;
}

template <class T>
std::string convert_numbers(const Hdf5Number& type, std::span<const std::uint8_t> stored, std::span<T> to) {
  if (type.kind == Hdf5Number::Kind::floating) {
    if (type.bytes == sizeof(float)) return convert_from<float>(stored, type.is_big_endian, to);
    return convert_from<double>(stored, type.is_big_endian, to);
  }
  if (type.kind == Hdf5Number::Kind::signed_integer) {
    return convert_from_integers<std::int8_t, std::int16_t, std::int32_t, std::int64_t>(type, stored, to);
  }
  return convert_from_integers<std::uint8_t, std::uint16_t, std::uint32_t, std::uint64_t>(type, stored, to);
}

template std::string convert_numbers(const Hdf5Number&, std::span<const std::uint8_t>, std::span<float>);
template std::string convert_numbers(const Hdf5Number&, std::span<const std::uint8_t>, std::span<double>);
template std::string convert_numbers(const Hdf5Number&, std::span<const std::uint8_t>,
                                     std::span<std::int8_t>);
template std::string convert_numbers(const Hdf5Number&, std::span<const std::uint8_t>,
                                     std::span<std::uint8_t>);
template std::string convert_numbers(const Hdf5Number&, std::span<const std::uint8_t>,
                                     std::span<std::int16_t>);
template std::string convert_numbers(const Hdf5Number&, std::span<const std::uint8_t>,
                                     std::span<std::uint16_t>);
template std::string convert_numbers(const Hdf5Number&, std::span<const std::uint8_t>,
                                     std::span<std::int32_t>);
template std::string convert_numbers(const Hdf5Number&, std::span<const std::uint8_t>,
                                     std::span<std::uint32_t>);
template std::string convert_numbers(const Hdf5Number&, std::span<const std::uint8_t>,
                                     std::span<std::int64_t>);
template std::string convert_numbers(const Hdf5Number&, std::span<const std::uint8_t>,
                                     std::span<std::uint64_t>);

std::vector<std::uint8_t> unshuffled(std::span<const std::uint8_t> bytes, std::size_t number_bytes) {
  const std::size_t count = bytes.size() / number_bytes;
  std::vector<std::uint8_t> numbers(bytes.size());
  const std::uint8_t* __restrict from = bytes.data();
  std::uint8_t* __restrict to = numbers.data();
  if (number_bytes == 2) {  // depth: most of all that is read
    for (std::size_t i = 0; i < count; ++i) {
      to[2 * i] = from[i];
      to[2 * i + 1] = from[count + i];
    }
    return numbers;
  }
  for (std::size_t byte = 0; byte < number_bytes; ++byte) {
    for (std::size_t i = 0; i < count; ++i) to[number_bytes * i + byte] = from[count * byte + i];
  }
  return numbers;
}

}  // namespace knuckle
