// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace knuckle {

/// The most whole numbers that a list may have.
inline constexpr std::size_t kMostIntegers = 1 << 16;

/// One field of a message in protocol buffers' wire format.
struct ProtobufField {
  enum class Kind { varint, fixed32, fixed64, bytes };
  std::uint32_t number = 0;
  Kind kind = Kind::varint;
  std::uint64_t value = 0;  ///< of the kinds varint, fixed32 and fixed64, as bits
  std::string_view bytes;   ///< of the kind bytes: a text, a message or packed numbers
};

/// Walks through the fields of one message, which may hold anything. Nothing is copied: the bytes have to
/// outlive the reader and its fields.
class ProtobufReader {
 public:
  /// `what` names the message in errors: "hand.onnx: node 3".
  ProtobufReader(std::string_view bytes, std::string what) : rest_(bytes), what_(std::move(what)) {}

  /// The next field; nothing at the end. Throws an Error where the bytes are no message.
  std::optional<ProtobufField> next();
  /// Throws an Error where this was called with a field of the same number before: readers differ in which of
  /// several they believe. For numbers below 64.
  void require_once(const ProtobufField& field);
  const std::string& what() const { return what_; }

  /// Throws an Error that names the message and the field's number.
  [[noreturn]] void fail_at(const ProtobufField& field, std::string_view fault) const;
  /// What a field of that kind holds. Throws an Error where it is of another kind.
  std::string_view bytes_of(const ProtobufField& field) const;
  std::int64_t integer_of(const ProtobufField& field) const;
  float real_of(const ProtobufField& field) const;
  /// Adds the numbers of a repeated field, packed or one by one. Throws an Error where there are more whole
  /// numbers than kMostIntegers: a byte of a file becomes eight in memory.
  void add_integers(const ProtobufField& field, std::vector<std::int64_t>& numbers) const;
  void add_reals(const ProtobufField& field, std::vector<float>& numbers) const;

 private:
  std::uint64_t varint();
  std::uint64_t fixed(std::size_t size);
  std::string_view take(std::uint64_t size);
  [[noreturn]] void fail_short() const;

  std::string_view rest_;
  std::string what_;
  std::uint64_t seen_ = 0;  ///< a bit per number that require_once was called with
};

}  // namespace knuckle
