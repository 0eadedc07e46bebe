// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_number.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;

template <class T>
std::vector<std::uint8_t> stored(const std::vector<T>& values, bool is_big_endian = false) {
  std::vector<std::uint8_t> bytes(values.size() * sizeof(T));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  if (is_big_endian) {
    for (std::size_t i = 0; i < bytes.size(); i += sizeof(T))
      std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(i),
                   bytes.begin() + static_cast<std::ptrdiff_t>(i + sizeof(T)));
  }
  return bytes;
}

/// Whether `value` comes back as a T; what it is then.
template <class T, class From>
std::string fault_of(From value, T& back) {
  return convert_numbers(number_of<From>(), stored(std::vector<From>{value}), std::span(&back, 1));
}

template <class T, class From>
void expect_fits(From value) {
  T back{};
  EXPECT_EQ(fault_of<T>(value, back), "");
  EXPECT_EQ(static_cast<From>(back), value);
}

template <class T, class From>
void expect_refused(From value) {
  T back{};
  EXPECT_NE(fault_of<T>(value, back), "") << value;
}

TEST(Hdf5Number, IntegersFitToTheirLimitsAndNotBeyond) {
  for (int value = -70000; value <= 70000; ++value) {
    std::int8_t small{};
    std::uint16_t depth{};
    EXPECT_EQ(fault_of<std::int8_t>(value, small).empty(), value >= -128 && value <= 127) << value;
    EXPECT_EQ(fault_of<std::uint16_t>(value, depth).empty(), value >= 0 && value <= 65535) << value;
    EXPECT_EQ(fault_of<std::uint16_t>(static_cast<float>(value), depth).empty(),
              value >= 0 && value <= 65535);
  }
  expect_fits<std::int64_t>(std::uint64_t{1} << 62);
  expect_refused<std::int64_t>(std::uint64_t{1} << 63);
  expect_refused<std::uint64_t>(std::int64_t{-1});
}

TEST(Hdf5Number, FractionsAndWhatIsNoNumberAreNoIntegers) {
  expect_fits<std::int32_t>(-3.0);
  expect_refused<std::int32_t>(-3.5);
  expect_refused<std::uint8_t>(-0.25F);
  expect_refused<std::int16_t>(std::numeric_limits<double>::quiet_NaN());
  expect_refused<std::int64_t>(std::numeric_limits<float>::infinity());
  expect_fits<std::int64_t>(-0x1p63);
  expect_refused<std::int64_t>(0x1p63);
  expect_refused<std::uint64_t>(0x1p64);
}

TEST(Hdf5Number, NumbersBecomeFloatsButNotInfinite) {
  expect_fits<float>(0x1p126);
  expect_refused<float>(1e39);
  expect_refused<float>(-1e39);
  expect_fits<float>(std::numeric_limits<double>::infinity());
  float back = 0;
  EXPECT_EQ(fault_of<float>(std::numeric_limits<double>::quiet_NaN(), back), "");
  EXPECT_TRUE(back != back);
  EXPECT_EQ(fault_of<float>(0.1, back), "");
  EXPECT_EQ(back, 0.1F);
}

template <class T>
void expect_order_is_heeded(const std::vector<T>& values) {
  for (const bool is_big_endian : {false, true}) {
    Hdf5Number type = number_of<T>();
    type.is_big_endian = is_big_endian;
    std::vector<double> back(values.size());
    EXPECT_EQ(convert_numbers(type, stored(values, is_big_endian), std::span(back)), "");
    EXPECT_THAT(back, ElementsAreArray(std::vector<double>(values.begin(), values.end())));
  }
}

TEST(Hdf5Number, BothOrdersOfBytesAreRead) {
  expect_order_is_heeded<std::int8_t>({-128, 127, 1});
  expect_order_is_heeded<std::uint8_t>({0, 255, 1});
  expect_order_is_heeded<std::int16_t>({-32768, 258, 1});
  expect_order_is_heeded<std::uint16_t>({65535, 258, 1});
  expect_order_is_heeded<std::int32_t>({-2147483647, 66051, 1});
  expect_order_is_heeded<std::uint32_t>({4294967295U, 66051, 1});
  expect_order_is_heeded<std::int64_t>({-281474976710656, 66051, 1});
  expect_order_is_heeded<std::uint64_t>({std::uint64_t{1} << 63, 66051, 1});
  expect_order_is_heeded<float>({-1.5F, 3e-40F, 1e30F});
  expect_order_is_heeded<double>({-1.5, 3e-310, 1e300});
}

TEST(Hdf5Number, UnshufflingGathersTheBytesOfANumber) {
  const std::vector<std::uint8_t> bytes{1, 2, 3, 11, 12, 13};
  EXPECT_THAT(unshuffled(bytes, 2), ElementsAre(1, 11, 2, 12, 3, 13));
  EXPECT_THAT(unshuffled(bytes, 3), ElementsAre(1, 3, 12, 2, 11, 13));
  EXPECT_THAT(unshuffled(bytes, 1), ElementsAreArray(bytes));
}

}  // namespace
}  // namespace knuckle
