// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_tree.h"

#include <vector>

namespace knuckle {
namespace {

/// The form of a tree's nodes.
struct NodeForm {
  const Hdf5Bytes& file;
  Hdf5TreeKind kind;
  std::size_t key_bytes;

  std::size_t head_bytes() const { return 8 + 2 * file.address_bytes(); }
  std::size_t entry_bytes() const { return key_bytes + file.address_bytes(); }
};

struct Node {
  int level = 0;  ///< 0: a leaf
  std::size_t count = 0;
  std::vector<std::uint8_t> bytes;
};

/// `most_bytes`: a node that takes more room is refused before it is read.
Node read_node(const NodeForm& form, std::uint64_t address, std::uint64_t most_bytes) {
  constexpr std::uint64_t kUsualBytes = 4096;
  Node node;
  node.bytes = form.file.read_at_most(address, kUsualBytes);
  Hdf5Cursor head(node.bytes, form.file);
  head.expect_signature("TREE");
  if (head.u8() != static_cast<std::uint8_t>(form.kind)) form.file.damaged("a tree is of another kind");
  node.level = head.u8();
  node.count = head.u16();
  const std::size_t needed = form.head_bytes() + node.count * form.entry_bytes() + form.key_bytes;
  if (needed > most_bytes) form.file.damaged("a tree has more nodes than the file can hold");
  if (needed > node.bytes.size()) node.bytes = form.file.read(address, needed);
  node.bytes.resize(needed);
  return node;
}

template <class Visit>
void for_each_entry_of(const Node& node, const NodeForm& form, const Visit& visit) {
  Hdf5Cursor entries(node.bytes, form.file);
  entries.skip(form.head_bytes());
  for (std::size_t i = 0; i < node.count; ++i) {
    const Hdf5Cursor key(entries.take(form.key_bytes), form.file);
    visit(key, entries.defined_address());
  }
}

class LeafWalk {
 public:
  using Visit = std::function<void(std::optional<Hdf5Cursor>, std::uint64_t)>;

  LeafWalk(const NodeForm& form, const Visit& visit)
      : form_(form), visit_(visit), bytes_left_(form.file.size()) {}

  void start(std::uint64_t root) {
    const Node node = read_node(form_, root, bytes_left_);
    if (node.level == 0) {
      visit_(std::nullopt, root);
    } else {
      visit_children(node);
    }
  }

 private:
  void visit_children(const Node& node) {
    bytes_left_ -= node.bytes.size();
    for_each_entry_of(node, form_, [&](Hdf5Cursor key, std::uint64_t address) {
      if (node.level == 1) return visit_(key, address);
      const Node child = read_node(form_, address, bytes_left_);
      if (child.level != node.level - 1) form_.file.damaged("a tree's node is of another level");
      visit_children(child);
    });
  }

  NodeForm form_;
  const Visit& visit_;
  std::uint64_t bytes_left_;
};

}  // namespace

void for_each_leaf(const Hdf5Bytes& file, std::uint64_t root, Hdf5TreeKind kind, std::size_t key_bytes,
                   const std::function<void(std::optional<Hdf5Cursor> key, std::uint64_t leaf)>& visit) {
  LeafWalk({file, kind, key_bytes}, visit).start(root);
}

void for_each_entry(const Hdf5Bytes& file, std::uint64_t leaf, Hdf5TreeKind kind, std::size_t key_bytes,
                    const std::function<void(Hdf5Cursor key, std::uint64_t child)>& visit) {
  const NodeForm form{file, kind, key_bytes};
  const Node node = read_node(form, leaf, file.size());
  if (node.level != 0) file.damaged("a tree's node is of another level");
  for_each_entry_of(node, form, visit);
}

}  // namespace knuckle
