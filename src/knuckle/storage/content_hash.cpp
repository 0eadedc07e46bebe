// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/content_hash.h"

#include <cstdio>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <xxhash.h>

#include "knuckle/core/error.h"
#include "knuckle/core/regular_file.h"

namespace knuckle {
namespace {

std::string hexadecimal(const XXH128_hash_t& hash) {
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace

std::string content_hash(const std::filesystem::path& file) {
  require_regular_file(file);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"), std::fclose);
  if (!stream) fail("{}: cannot be read", file.string());
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(),
                                                                              XXH3_freeState);
  XXH3_128bits_reset(state.get());
  std::vector<char> block(std::size_t{1} << 20);
  while (const std::size_t length = std::fread(block.data(), 1, block.size(), stream.get())) {
    XXH3_128bits_update(state.get(), block.data(), length);
  }
  if (std::ferror(stream.get()) != 0) fail("{}: cannot be read", file.string());
  return hexadecimal(XXH3_128bits_digest(state.get()));
}

std::string text_hash(std::string_view text) {
  return hexadecimal(XXH3_128bits(text.data(), text.size()));
}

std::uint64_t content_sum(std::span<const std::byte> bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

}  // namespace knuckle
