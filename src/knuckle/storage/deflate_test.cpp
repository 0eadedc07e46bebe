// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/deflate.h"

#include <string_view>

#include <zlib.h>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

/// What zlib makes of a stream.
std::vector<std::uint8_t> inflated(const std::vector<std::uint8_t>& stream, std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  uLongf length = size;
  EXPECT_EQ(uncompress(bytes.data(), &length, stream.data(), stream.size()), Z_OK);
  EXPECT_EQ(length, size);
  return bytes;
}

/// Plain areas beside noise of `values` different values.
std::vector<std::uint8_t> patches(Random& random, std::size_t size, std::uint32_t values) {
  std::vector<std::uint8_t> bytes;
  while (bytes.size() < size) {
    const std::size_t length = 1 + random.below(600);
    const bool is_plain = random.below(2) == 0;
    auto value = static_cast<std::uint8_t>(random.below(values));
    for (std::size_t i = 0; i < length; ++i) {
      if (!is_plain) value = static_cast<std::uint8_t>(random.below(values));
      bytes.push_back(value);
    }
  }
  bytes.resize(size);
  return bytes;
}

TEST(Deflate, ZlibReadsWhatItMakes) {
  Random random(5);
  for (const std::size_t size : {1, 2, 3, 4, 257, 258, 259, 260, 1000, 40000}) {
    for (const std::uint32_t values : {1u, 2u, 17u, 256u}) {
      const std::vector<std::uint8_t> bytes = patches(random, size, values);
      EXPECT_EQ(inflated(deflated(bytes), size), bytes) << size << " " << values;
    }
  }
}

TEST(Deflate, ZlibReadsRunsOfEveryLength) {
  for (const std::size_t gap : {1, 2, 40}) {
    std::vector<std::uint8_t> bytes;
    for (std::size_t run = 1; run < 600; ++run) {
      bytes.insert(bytes.end(), gap, static_cast<std::uint8_t>(run));
      bytes.insert(bytes.end(), run, static_cast<std::uint8_t>(run / 256));
    }
    EXPECT_EQ(inflated(deflated(bytes), bytes.size()), bytes) << gap;
  }
}

TEST(Deflate, ZlibReadsAHandBeforeNothing) {
  Random random(11);
  std::vector<std::uint8_t> bytes(153600, 0);  // an image of 320 x 240, its bytes of two kinds apart
  for (std::size_t row = 60; row < 180; ++row) {
    for (std::size_t column = 100; column < 160; ++column) {
      bytes[row * 320 + column] = static_cast<std::uint8_t>(random.below(1 + random.below(256)));
      bytes[76800 + row * 320 + column] = static_cast<std::uint8_t>(2 + random.below(2));
    }
  }
  EXPECT_EQ(inflated(deflated(bytes), bytes.size()), bytes);
}

TEST(Deflate, MakesPlainAreasSmallAndNoiseHardlyLarger) {
  EXPECT_LT(deflated(std::vector<std::uint8_t>(100000, 7)).size(), 200u);
  Random random(9);
  std::vector<std::uint8_t> noise(100000);
  for (auto& byte : noise) byte = static_cast<std::uint8_t>(random.below(256));
  EXPECT_LT(deflated(noise).size(), 100500u);
}

TEST(Deflate, ChecksumOfAKnownText) {
  const std::string_view text = "Wikipedia";  // 0x11e60398, the example that the checksum's article gives
  EXPECT_EQ(adler32({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}), 0x11e60398u);
}

TEST(Deflate, ShuffledPutsLowBytesFirst) {
  EXPECT_EQ(shuffled(std::vector<std::uint16_t>{0x0102, 0x0304}), (std::vector<std::uint8_t>{2, 4, 1, 3}));
}

TEST(Crc32, GoesOnFromPartToPart) {
  Random random(7);
  const std::vector<std::uint8_t> bytes = patches(random, 1000, 256);
  const std::uint32_t whole = crc32(bytes);
  EXPECT_EQ(whole, ::crc32(0, bytes.data(), 1000));  // zlib's
  for (const std::size_t part : {0, 1, 500, 1000}) {
    const std::span<const std::uint8_t> all(bytes);
    EXPECT_EQ(crc32(all.subspan(part), crc32(all.first(part))), whole) << part;
  }
}

}  // namespace
}  // namespace knuckle
