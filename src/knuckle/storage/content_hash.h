// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace knuckle {

/// The XXH3 hash (128 bits, hexadecimal) of a file's content. Throws an Error that names the file where it
/// cannot be read.
std::string content_hash(const std::filesystem::path& file);

/// The same hash of a text.
std::string text_hash(std::string_view text);

/// A sum of bytes (XXH3, 64 bits), another one for each seed: against damage.
std::uint64_t content_sum(std::span<const std::byte> bytes, std::uint64_t seed);

}  // namespace knuckle
