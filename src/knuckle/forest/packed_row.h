// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/core/worker_messages.h"

namespace knuckle {

// A row of features in a message to another worker: most of a patch is background, of one value. The row's
// first value, then a bit for each eight values, 1 where they are not all that value, then these eights, then
// what is left over of the row. No row becomes longer than by 3 bytes and one for each 64 values.

/// Bytes that append_packed appends.
std::size_t packed_bytes(std::span<const std::int16_t> row);

/// Appends a row, which is not empty.
void append_packed(std::vector<std::byte>& message, std::span<const std::int16_t> row);

/// Reads a row of this length. Throws an Error where the message ends before, or has values that
/// the row has not.
void read_packed(MessageReader& reader, std::span<std::int16_t> row);

}  // namespace knuckle
