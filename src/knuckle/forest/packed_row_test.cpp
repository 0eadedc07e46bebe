// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/packed_row.h"

#include <algorithm>
#include <limits>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

std::vector<std::byte> packed(const std::vector<std::int16_t>& row) {
  std::vector<std::byte> message{std::byte{7}};  // something before it
  append_packed(message, row);
  EXPECT_EQ(message.size(), 1 + packed_bytes(row));
  return {message.begin() + 1, message.end()};
}

std::vector<std::int16_t> unpacked(std::span<const std::byte> message, std::size_t length) {
  std::vector<std::int16_t> row(length, 99);
  MessageReader reader(message);
  read_packed(reader, row);
  EXPECT_TRUE(reader.is_at_end());
  return row;
}

TEST(PackedRow, ArrivesAsItWas) {
  Random random(3);
  for (int round = 0; round < 300; ++round) {
    std::vector<std::int16_t> row(1 + random.below(200), static_cast<std::int16_t>(random()));
    const std::uint32_t changes = random.below(1 + static_cast<std::uint32_t>(row.size()));
    for (std::uint32_t i = 0; i < changes; ++i) {
      row[random.below(static_cast<std::uint32_t>(row.size()))] = static_cast<std::int16_t>(random());
    }
    EXPECT_EQ(unpacked(packed(row), row.size()), row);
  }
  for (const std::int16_t value :
       {std::numeric_limits<std::int16_t>::min(), std::numeric_limits<std::int16_t>::max()}) {
    EXPECT_EQ(unpacked(packed({value, 1, 2}), 3), (std::vector<std::int16_t>{value, 1, 2}));
  }
}

TEST(PackedRow, BackgroundTakesNoRoom) {
  std::vector<std::int16_t> row(96 * 96, 4096);
  EXPECT_EQ(packed(row).size(), 2u + 96 * 96 / 64);
  row[5000] = 1;
  row[5001] = 4095;
  row.back() = 3;
  EXPECT_EQ(packed(row).size(), 2u + 96 * 96 / 64 + 2 * 16);
  for (std::size_t i = 0; i < row.size(); ++i) row[i] = static_cast<std::int16_t>(i);
  EXPECT_EQ(packed(row).size(), 2u + 96 * 96 / 64 + 2 * 96 * 96) << "nothing to leave out";
}

TEST(PackedRow, ThatEndsEarlyIsRefused) {
  std::vector<std::int16_t> row(20, 1);
  row[9] = 2;
  const std::vector<std::byte> message = packed(row);
  for (std::size_t length = 0; length < message.size(); ++length) {
    EXPECT_THAT(error_of([&] {
                  MessageReader reader(std::span<const std::byte>(message).first(length));
                  read_packed(reader, row);
                }),
                HasSubstr("ends early"))
        << length;
  }
}

TEST(PackedRow, BitsBeyondTheRowAreRefused) {
  std::vector<std::byte> message = packed(std::vector<std::int16_t>(16, 1));  // two eights: two bits
  message[2] = std::byte{0x80};
  std::vector<std::int16_t> row(16);
  EXPECT_THAT(error_of([&] {
                MessageReader reader(message);
                read_packed(reader, row);
              }),
              HasSubstr("beyond"));
}

}  // namespace
}  // namespace knuckle
