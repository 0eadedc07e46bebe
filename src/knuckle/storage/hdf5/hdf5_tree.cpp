// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_tree.h"

#include <optional>
#include <vector>

namespace knuckle {
namespace {

class TreeWalk {
 public:
  TreeWalk(const Hdf5Bytes& file, Hdf5TreeKind kind, std::size_t key_bytes,
           const std::function<void(Hdf5Cursor, std::uint64_t)>& visit)
      : file_(file), kind_(kind), key_bytes_(key_bytes), visit_(visit), bytes_left_(file.size()) {}

  void visit_node(std::uint64_t address, std::optional<int> expected_level) {
    constexpr std::uint64_t kUsualBytes = 4096;
    const std::size_t head_bytes = 8 + 2 * file_.address_bytes();
    std::vector<std::uint8_t> bytes = file_.read_at_most(address, kUsualBytes);
    Hdf5Cursor head(bytes, file_);
    head.expect_signature("TREE");
    if (head.u8() != static_cast<std::uint8_t>(kind_)) file_.damaged("a tree is of another kind");
    const int level = head.u8();
    if (expected_level && level != *expected_level) file_.damaged("a tree's node is of another level");
    const std::size_t count = head.u16();
    const std::size_t entry_bytes = key_bytes_ + file_.address_bytes();
    const std::size_t node_bytes = head_bytes + count * entry_bytes + key_bytes_;
    if (node_bytes > bytes_left_) file_.damaged("a tree has more nodes than the file can hold");
    bytes_left_ -= node_bytes;
    if (node_bytes > bytes.size()) bytes = file_.read(address, node_bytes);
    Hdf5Cursor entries(bytes, file_);
    entries.skip(head_bytes);
    for (std::size_t i = 0; i < count; ++i) {
      const Hdf5Cursor key(entries.take(key_bytes_), file_);
      const std::uint64_t child = entries.defined_address();
      if (level > 0) {
        visit_node(child, level - 1);
      } else {
        visit_(key, child);
      }
    }
  }

 private:
  const Hdf5Bytes& file_;
  Hdf5TreeKind kind_;
  std::size_t key_bytes_;
  const std::function<void(Hdf5Cursor, std::uint64_t)>& visit_;
  std::uint64_t bytes_left_;
};

}  // namespace

void for_each_leaf_entry(const Hdf5Bytes& file, std::uint64_t root, Hdf5TreeKind kind, std::size_t key_bytes,
                         const std::function<void(Hdf5Cursor key, std::uint64_t child)>& visit) {
  TreeWalk(file, kind, key_bytes, visit).visit_node(root, std::nullopt);
}

}  // namespace knuckle
