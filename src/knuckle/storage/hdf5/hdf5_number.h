// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "knuckle/storage/hdf5/hdf5_bytes.h"

namespace knuckle {

/// How a number is stored.
struct Hdf5Number {
  enum class Kind { unsigned_integer, signed_integer, floating };

  std::size_t bytes = 1;
  Kind kind = Kind::unsigned_integer;
  bool is_big_endian = false;

  bool operator==(const Hdf5Number&) const = default;
};

/// What an array's or an attribute's elements are (File Format Specification, IV.A.2.d).
struct Hdf5Type {
  enum class Kind { number, text, variable_text, other };

  Kind kind = Kind::other;
  std::uint32_t bytes = 0;  ///< of an element
  Hdf5Number number;        ///< where it is one
};

/// Integers and IEEE 754 numbers of 1 to 8 bytes are numbers; others, with bits that are left out, are not.
Hdf5Type read_type(Hdf5Cursor cursor);

/// The type as it lies in memory.
template <class T>
constexpr Hdf5Number number_of() {
  using Kind = Hdf5Number::Kind;
  if (std::is_floating_point_v<T>) return {sizeof(T), Kind::floating, false};
  return {sizeof(T), std::is_signed_v<T> ? Kind::signed_integer : Kind::unsigned_integer, false};
}

/// Stored numbers as T. Returns the first that T cannot hold, as text; empty where it can hold all: integers
/// are never rounded or clipped, floating-point numbers are rounded but do not become infinite.
/// `stored` has as many numbers as `to`.
template <class T>
std::string convert_numbers(const Hdf5Number& type, std::span<const std::uint8_t> stored, std::span<T> to);

/// The first bytes of all numbers, then the second bytes of all, ... (the filter `shuffle`): back to numbers.
std::vector<std::uint8_t> unshuffled(std::span<const std::uint8_t> bytes, std::size_t number_bytes);

}  // namespace knuckle
