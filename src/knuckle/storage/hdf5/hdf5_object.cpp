// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_object.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "knuckle/core/limits.h"
#include "knuckle/storage/hdf5/hdf5_tree.h"

namespace knuckle {
namespace {

constexpr std::string_view kNewHeader = "OHDR";
constexpr std::string_view kNewContinuation = "OCHK";
constexpr std::size_t kChecksumBytes = 4;

/// The blocks of an object's header, each of which may name others.
class ObjectReader {
 public:
  explicit ObjectReader(const Hdf5Bytes& file) : file_(file) {}

  std::vector<Hdf5Message> read(std::uint64_t address) {
    constexpr std::uint64_t kMostOfPrefix = 64;
    const std::vector<std::uint8_t> start = file_.read_at_most(address, kMostOfPrefix);
    const bool is_new =
        start.size() >= kNewHeader.size() && std::equal(kNewHeader.begin(), kNewHeader.end(), start.begin());
    Hdf5Cursor prefix(start, file_);
    const auto [skipped, bytes] = is_new ? new_prefix(prefix) : old_prefix(prefix);
    blocks_.push_back({address + skipped, bytes});
    for (std::size_t i = 0; i < blocks_.size(); ++i) read_block(blocks_[i], is_new, i > 0);
    return std::move(messages_);
  }

 private:
  struct Block {
    std::uint64_t address;
    std::uint64_t bytes;
  };

  /// Bytes before the first block, and in it.
  std::pair<std::uint64_t, std::uint64_t> old_prefix(Hdf5Cursor& prefix) const {
    constexpr std::uint64_t kOldPrefixBytes = 16;
    const int version = prefix.u8();
    if (version != 1) file_.damaged("an object has no header");
    prefix.skip(7);  // numbers of messages and of references
    return {kOldPrefixBytes, prefix.u32()};
  }

  std::pair<std::uint64_t, std::uint64_t> new_prefix(Hdf5Cursor& prefix) {
    const std::size_t all = prefix.left();
    prefix.skip(kNewHeader.size());
    if (prefix.u8() != 2) file_.damaged("an object's header is of an unknown version");
    const unsigned flags = prefix.u8();
    message_head_bytes_ = (flags & 0x04U) != 0 ? 6 : 4;
    if ((flags & 0x20U) != 0) prefix.skip(16);  // times
    if ((flags & 0x10U) != 0) prefix.skip(4);   // when attributes leave the header
    const std::uint64_t bytes = prefix.number(std::size_t{1} << (flags & 0x03U));
    return {all - prefix.left(), bytes};
  }

  void read_block(const Block block, bool is_new, bool is_continuation) {
    total_bytes_ += std::min(block.bytes, file_.size());
    if (total_bytes_ > static_cast<std::uint64_t>(limits::kObjectHeaderBytes)) {
      file_.damaged(fmt::format("an object's header has more than {} bytes", limits::kObjectHeaderBytes));
    }
    const std::vector<std::uint8_t> bytes = file_.read(block.address, block.bytes);
    Hdf5Cursor cursor(bytes, file_);
    if (!is_new) {
      while (cursor.left() >= 8) read_old_message(cursor);
      return;
    }
    if (is_continuation) cursor.expect_signature(kNewContinuation);
    const std::size_t behind = is_continuation ? kChecksumBytes : 0;
    while (cursor.left() >= message_head_bytes_ + behind) read_new_message(cursor);
  }

  void read_old_message(Hdf5Cursor& cursor) {
    const std::uint16_t type = cursor.u16();
    const std::uint16_t size = cursor.u16();
    const unsigned flags = cursor.u8();
    cursor.skip(3);
    keep(type, flags, cursor.take(size));
  }

  void read_new_message(Hdf5Cursor& cursor) {
    const std::uint16_t type = cursor.u8();
    const std::uint16_t size = cursor.u16();
    const unsigned flags = cursor.u8();
    cursor.skip(message_head_bytes_ - 4);  // order of creation
    keep(type, flags, cursor.take(size));
  }

  void keep(std::uint16_t type, unsigned flags, std::span<const std::uint8_t> bytes) {
    constexpr unsigned kShared = 0x02;
    const auto known = static_cast<Hdf5MessageType>(type);
    if (known != Hdf5MessageType::continuation) {
      messages_.push_back({known, (flags & kShared) != 0, {bytes.begin(), bytes.end()}});
      return;
    }
    Hdf5Cursor cursor(bytes, file_);
    const std::uint64_t address = cursor.defined_address();
    blocks_.push_back({address, cursor.length()});
  }

  const Hdf5Bytes& file_;
  std::vector<Block> blocks_;
  std::vector<Hdf5Message> messages_;
  std::uint64_t total_bytes_ = 0;
  std::size_t message_head_bytes_ = 4;
};

/// The names of an old group (III.D).
class NameHeap {
 public:
  NameHeap(const Hdf5Bytes& file, std::uint64_t address) : file_(file) {
    const std::vector<std::uint8_t> head =
        file.read(address, 8 + 2 * file.length_bytes() + file.address_bytes());
    Hdf5Cursor cursor(head, file);
    cursor.expect_signature("HEAP");
    cursor.skip(4);
    const std::uint64_t bytes = cursor.length();
    cursor.length();
    if (bytes > static_cast<std::uint64_t>(limits::kObjectHeaderBytes)) {
      file.damaged("a group has more names than it may");
    }
    names_ = file.read(cursor.defined_address(), bytes);
  }

  std::string name_at(std::uint64_t place) const {
    if (place >= names_.size()) file_.damaged("a name lies outside of its heap");
    const auto begin = names_.begin() + static_cast<std::ptrdiff_t>(place);
    const auto last = begin + std::min<std::ptrdiff_t>(limits::kNameLength, names_.end() - begin);
    const auto end = std::find(begin, last, 0);
    if (end == last) file_.damaged("a name does not end");
    return {begin, end};
  }

 private:
  const Hdf5Bytes& file_;
  std::vector<std::uint8_t> names_;
};

/// The links of an old group, whose tree leads to nodes of symbols (III.B, III.C).
class OldGroup {
 public:
  OldGroup(const Hdf5Bytes& file, const Hdf5Message& message, Hdf5Links& links)
      : file_(file),
        cursor_(message.bytes, file),
        tree_(cursor_.defined_address()),
        names_(file, cursor_.defined_address()),
        links_(links),
        bytes_left_(file.size()) {}

  void read() {
    const std::size_t key_bytes = file_.length_bytes();
    const auto visit = [&](const Hdf5Cursor&, std::uint64_t node) { read_symbols(node); };
    for_each_leaf(file_, tree_, Hdf5TreeKind::group, key_bytes,
                  [&](const std::optional<Hdf5Cursor>&, std::uint64_t leaf) {
                    for_each_entry(file_, leaf, Hdf5TreeKind::group, key_bytes, visit);
                  });
  }

 private:
  void read_symbols(std::uint64_t address) {
    constexpr std::uint64_t kHeadBytes = 8;
    const std::vector<std::uint8_t> head_bytes = file_.read(address, kHeadBytes);
    Hdf5Cursor head(head_bytes, file_);
    head.expect_signature("SNOD");
    head.skip(2);
    const std::uint64_t count = head.u16();
    const std::uint64_t bytes_of_all = count * (2 * file_.address_bytes() + 24);
    if (kHeadBytes + bytes_of_all > bytes_left_)
      file_.damaged("a group has more links than the file can hold");
    bytes_left_ -= kHeadBytes + bytes_of_all;
    const std::vector<std::uint8_t> bytes = file_.read(address + kHeadBytes, bytes_of_all);
    Hdf5Cursor symbols(bytes, file_);
    for (std::uint64_t i = 0; i < count; ++i) read_symbol(symbols);
  }

  void read_symbol(Hdf5Cursor& symbols) {
    constexpr std::uint32_t kLinkByName = 2;
    const std::string name = names_.name_at(symbols.number(file_.address_bytes()));
    const std::optional<std::uint64_t> object = symbols.address();
    const bool is_by_name = symbols.u32() == kLinkByName;
    symbols.skip(20);
    links_.insert_or_assign(name, is_by_name ? std::nullopt : object);
  }

  const Hdf5Bytes& file_;
  Hdf5Cursor cursor_;
  std::uint64_t tree_;
  NameHeap names_;
  Hdf5Links& links_;
  std::uint64_t bytes_left_;  ///< no node may be there twice
};

void read_link(const Hdf5Bytes& file, const Hdf5Message& message, Hdf5Links& links) {
  Hdf5Cursor cursor(message.bytes, file);
  if (cursor.u8() != 1) file.damaged("a link is of an unknown version");
  const unsigned flags = cursor.u8();
  const bool is_hard = (flags & 0x08U) == 0 || cursor.u8() == 0;
  if ((flags & 0x04U) != 0) cursor.skip(8);  // order of creation
  if ((flags & 0x10U) != 0) cursor.skip(1);  // character set
  const std::span<const std::uint8_t> name = cursor.take(cursor.number(std::size_t{1} << (flags & 0x03U)));
  links.insert_or_assign(std::string(name.begin(), name.end()),
                         is_hard ? std::optional(cursor.defined_address()) : std::nullopt);
}

void refuse_links_outside_header(const Hdf5Bytes& file, const Hdf5Message& message) {
  Hdf5Cursor cursor(message.bytes, file);
  cursor.skip(1);
  if ((cursor.u8() & 0x01U) != 0) cursor.skip(8);
  if (cursor.address()) file.too_new("a group of many links");
}

}  // namespace

std::vector<Hdf5Message> read_object(const Hdf5Bytes& file, std::uint64_t address) {
  return ObjectReader(file).read(address);
}

const Hdf5Message* find_message(const std::vector<Hdf5Message>& messages, Hdf5MessageType type) {
  const auto found = std::ranges::find(messages, type, &Hdf5Message::type);
  return found == messages.end() ? nullptr : &*found;
}

Hdf5Links read_links(const Hdf5Bytes& file, const std::vector<Hdf5Message>& messages) {
  Hdf5Links links;
  for (const Hdf5Message& message : messages) {
    if (message.type == Hdf5MessageType::symbol_table) OldGroup(file, message, links).read();
    if (message.type == Hdf5MessageType::link) read_link(file, message, links);
    if (message.type == Hdf5MessageType::link_info) refuse_links_outside_header(file, message);
  }
  return links;
}

}  // namespace knuckle
