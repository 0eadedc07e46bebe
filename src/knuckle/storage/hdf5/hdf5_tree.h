// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "knuckle/storage/hdf5/hdf5_bytes.h"

namespace knuckle {

/// What a B-tree of version 1 leads to (File Format Specification, III.A.1).
enum class Hdf5TreeKind : std::uint8_t { group = 0, chunks = 1 };

/// Calls `visit` with the address of each leaf, from the least keys to the greatest, and with the key that
/// its parent has for it, where it has a parent. The leaves themselves are not read. Throws where the tree is
/// damaged: a child must be a level lower than its parent, and all nodes together may not have more bytes
/// than the file, so trees that lead back to themselves end.
void for_each_leaf(const Hdf5Bytes& file, std::uint64_t root, Hdf5TreeKind kind, std::size_t key_bytes,
                   const std::function<void(std::optional<Hdf5Cursor> key, std::uint64_t leaf)>& visit);

/// Calls `visit` with the key and the child of each entry of a leaf.
void for_each_entry(const Hdf5Bytes& file, std::uint64_t leaf, Hdf5TreeKind kind, std::size_t key_bytes,
                    const std::function<void(Hdf5Cursor key, std::uint64_t child)>& visit);

}  // namespace knuckle
