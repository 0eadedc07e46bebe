// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/storage/hdf5/hdf5_bytes.h"

namespace knuckle {

/// Types of the messages that are read (File Format Specification, IV.A.2).
enum class Hdf5MessageType : std::uint16_t {
  dataspace = 0x01,
  link_info = 0x02,
  datatype = 0x03,
  fill_value = 0x05,
  link = 0x06,
  external_files = 0x07,
  layout = 0x08,
  filters = 0x0b,
  attribute = 0x0c,
  continuation = 0x10,
  symbol_table = 0x11,
  attribute_info = 0x15,
};

/// A message of an object's header.
struct Hdf5Message {
  Hdf5MessageType type;
  bool is_shared;  ///< its bytes tell where it lies, in place of the message
  std::vector<std::uint8_t> bytes;
};

/// All messages of the object whose header, of version 1 or 2, lies at that address.
std::vector<Hdf5Message> read_object(const Hdf5Bytes& file, std::uint64_t address);

/// The first message of that type; null where there is none.
const Hdf5Message* find_message(const std::vector<Hdf5Message>& messages, Hdf5MessageType type);

/// The objects of a group by name: their addresses, or nothing for links by name, which may lead out of the
/// file.
using Hdf5Links = std::map<std::string, std::optional<std::uint64_t>, std::less<>>;

/// Reads old groups (a B-tree, a heap of names) and new ones whose links lie in the header.
Hdf5Links read_links(const Hdf5Bytes& file, const std::vector<Hdf5Message>& messages);

}  // namespace knuckle
