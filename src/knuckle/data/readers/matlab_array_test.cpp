// SPDX-License-Identifier: Apache-2.0
// Files are made by matio, and by hand where matio writes one way only (level 5 of MathWorks' "MAT-File
// Format").
#include "knuckle/data/readers/matlab_array.h"

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include <matio.h>

#include "knuckle/core/testing.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/recording_testing.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::put_file;

template <class T>
std::string bytes_of(T value) {
  std::string bytes;
  const auto* first = reinterpret_cast<const char*>(&value);
  bytes.assign(first, sizeof(T));
  return bytes;
}

std::string tagged(std::uint32_t type, const std::string& content) {
  std::string bytes = bytes_of(type) + bytes_of(static_cast<std::uint32_t>(content.size())) + content;
  bytes.resize((bytes.size() + 7) / 8 * 8);
  return bytes;
}

/// At most four bytes, in the short form.
std::string small(std::uint16_t type, const std::string& content) {
  std::string bytes = bytes_of(type) + bytes_of(static_cast<std::uint16_t>(content.size())) + content;
  bytes.resize(8);
  return bytes;
}

const std::string kFlags = tagged(6, bytes_of(std::uint32_t{6}) + bytes_of(std::uint32_t{0}));
const std::string kTwoByThree = tagged(5, bytes_of(std::int32_t{2}) + bytes_of(std::int32_t{3}));
const std::string kName = small(1, "abc");

std::string header() {
  std::string bytes(124, ' ');
  bytes += std::string("\x00\x01IM", 4);
  return bytes;
}

std::string matrix(const std::string& content) {
  return bytes_of(std::uint32_t{14}) + bytes_of(static_cast<std::uint32_t>(content.size())) + content;
}

std::string packed(const std::string& element) {
  const std::string bytes = testing::packed(element, "zlib");
  return bytes_of(std::uint32_t{15}) + bytes_of(static_cast<std::uint32_t>(bytes.size())) + bytes;
}

std::vector<double> values_of(MatlabArray& array, std::size_t count) {
  std::vector<double> values(count);
  array.read(values);
  array.require_end();
  return values;
}

template <class T>
std::string stored(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) bytes += bytes_of(value);
  return bytes;
}

struct MatlabArrayTest : ::testing::Test {
  std::string error_of_file(const std::string& bytes, std::size_t count = 6) {
    put_file(path, bytes);
    return error_of([&] {
      MatlabArray array(path, "abc");
      values_of(array, count);
    });
  }

  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.mat";
};

TEST_F(MatlabArrayTest, DoublesAreReadFromEveryTypeThatTheyAreStoredAs) {
  const std::vector<std::pair<std::string, std::vector<double>>> cases{
      {tagged(1, stored<std::int8_t>({-128, -1, 0, 1, 2, 127})), {-128, -1, 0, 1, 2, 127}},
      {tagged(2, stored<std::uint8_t>({0, 1, 2, 3, 200, 255})), {0, 1, 2, 3, 200, 255}},
      {tagged(3, stored<std::int16_t>({-32768, -2, 0, 1, 300, 32767})), {-32768, -2, 0, 1, 300, 32767}},
      {tagged(4, stored<std::uint16_t>({0, 1, 2, 3, 40000, 65535})), {0, 1, 2, 3, 40000, 65535}},
      {tagged(5, stored<std::int32_t>({-2147483647, -1, 0, 1, 2, 70000})), {-2147483647, -1, 0, 1, 2, 70000}},
      {tagged(6, stored<std::uint32_t>({0, 1, 2, 3, 4, 4294967295})), {0, 1, 2, 3, 4, 4294967295}},
      {tagged(7, stored<float>({-0.5F, 0, 1, 2, 3, 1e20F})), {-0.5, 0, 1, 2, 3, 1e20F}},
      {tagged(9, stored<double>({-0.1, 0, 1, 2, 3, 1e200})), {-0.1, 0, 1, 2, 3, 1e200}},
      {tagged(12, stored<std::int64_t>({-5, 0, 1, 2, 3, 1099511627776})), {-5, 0, 1, 2, 3, 1099511627776}},
      {tagged(13, stored<std::uint64_t>({5, 0, 1, 2, 3, 9007199254740992})),
       {5, 0, 1, 2, 3, 9007199254740992}},
  };
  for (const auto& [element, expected] : cases) {
    const std::string content = matrix(kFlags + kTwoByThree + kName + element);
    for (const std::string& file : {header() + content, header() + packed(content)}) {
      put_file(path, file);
      MatlabArray array(path, "abc");
      EXPECT_EQ(array.shape(), (std::vector<std::int64_t>{2, 3}));
      EXPECT_EQ(values_of(array, 6), expected);
    }
  }
}

TEST_F(MatlabArrayTest, ReadsASmallElementAndAnEmptyArray) {
  const std::string two = tagged(5, bytes_of(std::int32_t{2}) + bytes_of(std::int32_t{1}));
  put_file(path, header() + matrix(kFlags + two + kName + small(3, stored<std::int16_t>({-7, 9}))));
  MatlabArray array(path, "abc");
  EXPECT_EQ(values_of(array, 2), (std::vector<double>{-7, 9}));
  const std::string none = tagged(5, bytes_of(std::int32_t{0}) + bytes_of(std::int32_t{3}));
  put_file(path, header() + matrix(kFlags + none + kName + tagged(9, "")));
  MatlabArray empty(path, "abc");
  EXPECT_EQ(empty.shape(), (std::vector<std::int64_t>{0, 3}));
  EXPECT_EQ(values_of(empty, 0), std::vector<double>{});
}

TEST_F(MatlabArrayTest, FindsItsArrayAmongOthersThatMatioWrote) {
  for (const matio_compression compression : {MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB}) {
    fs::remove(path);
    mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
    const auto put = [&](matvar_t* array) {
      ASSERT_EQ(Mat_VarWrite(file, array, compression), 0);
      Mat_VarFree(array);
    };
    std::array<std::size_t, 2> text_dims{1, 5};
    std::string text = "words";
    put(Mat_VarCreate("text", MAT_C_CHAR, MAT_T_UTF8, 2, text_dims.data(), text.data(), 0));
    std::array<std::size_t, 2> one{1, 1};
    std::array<const char*, 1> fields{"abc"};
    put(Mat_VarCreateStruct("record", 2, one.data(), fields.data(), 1));
    std::array<std::size_t, 3> dims{30, 40, 50};
    std::vector<double> values(60000);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::sin(static_cast<double>(i));
    put(Mat_VarCreate("abc", MAT_C_DOUBLE, MAT_T_DOUBLE, 3, dims.data(), values.data(), 0));
    put(Mat_VarCreate("after", MAT_C_DOUBLE, MAT_T_DOUBLE, 3, dims.data(), values.data(), 0));
    Mat_Close(file);
    MatlabArray array(path, "abc");
    EXPECT_EQ(array.shape(), (std::vector<std::int64_t>{30, 40, 50}));
    std::vector<double> first(7);
    array.read(first);
    EXPECT_TRUE(std::equal(first.begin(), first.end(), values.begin()));
    const std::vector<double> rest = values_of(array, values.size() - 7);
    EXPECT_TRUE(std::equal(rest.begin(), rest.end(), values.begin() + 7));
    testing::cut_file(path, fs::file_size(path) - 100);
    EXPECT_THAT(error_of([&] { MatlabArray(path, "abc"); }), HasSubstr("cut short")) << "in another array";
  }
}

TEST_F(MatlabArrayTest, HeadsThatAskForTheMachineAreRefused) {
  const std::string values = tagged(9, std::string(48, '\0'));
  const std::string long_name = bytes_of(std::uint32_t{1}) + bytes_of(std::uint32_t{0x91000009}) + "abc";
  EXPECT_THAT(error_of_file(header() + matrix(kFlags + kTwoByThree + long_name + values)),
              HasSubstr("a.mat: at byte 136: is damaged"));
  const std::string many_axes = bytes_of(std::uint32_t{5}) + bytes_of(std::uint32_t{0x40000000}) + "abcdefgh";
  EXPECT_THAT(error_of_file(header() + matrix(kFlags + many_axes + kName + values)), HasSubstr("is damaged"));
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  const std::string vast = tagged(5, stored<std::int32_t>({kMost, kMost, kMost, kMost, 16}));
  for (const std::string& content : {matrix(kFlags + vast + kName + values), matrix(kFlags + vast + kName)}) {
    EXPECT_THAT(error_of_file(header() + packed(content)), HasSubstr("a.mat"));
  }
  EXPECT_THAT(error_of_file(header() + packed(matrix(kFlags + vast + kName + values))),
              HasSubstr("more values than the file can hold"));
  const std::string around = tagged(5, stored<std::int32_t>({1 << 30, 1 << 30, 16}));  // 2^64, in 64 bits: 0
  EXPECT_THAT(error_of_file(header() + matrix(kFlags + around + kName + tagged(9, ""))),
              HasSubstr("more values than the file can hold"));
  const std::string backwards = tagged(5, stored<std::int32_t>({-2, -3}));
  EXPECT_THAT(error_of_file(header() + matrix(kFlags + backwards + kName + values)), HasSubstr("length -2"));
}

TEST_F(MatlabArrayTest, ValuesThatDoNotFitTheirShapeAreRefused) {
  const std::string head = kFlags + kTwoByThree + kName;
  EXPECT_THAT(error_of_file(header() + matrix(head + tagged(9, std::string(40, '\0')))),
              HasSubstr("6 values in 40 bytes"));
  EXPECT_THAT(error_of_file(header() + matrix(head + tagged(8, std::string(48, '\0')))), HasSubstr("type 8"));
  const std::string complex = tagged(6, bytes_of(std::uint32_t{0x806}) + bytes_of(std::uint32_t{0}));
  EXPECT_THAT(
      error_of_file(header() + matrix(complex + kTwoByThree + kName + tagged(9, std::string(48, '\0')))),
      HasSubstr("not an array of doubles"));
}

TEST_F(MatlabArrayTest, IsReadToItsEndAndNoFarther) {
  const std::string content = matrix(kFlags + kTwoByThree + kName + tagged(9, std::string(48, '\0')));
  EXPECT_THAT(error_of_file(header() + content, 7), HasSubstr("has 6 values left, asked for 7"));
  EXPECT_THAT(error_of_file(header() + content, 5), HasSubstr("1 of its values were not read"));
  std::string short_head = content;
  short_head[4] = static_cast<char>(short_head[4] - 8);  // the array ends before its last value does
  EXPECT_THAT(error_of_file(header() + packed(short_head)), HasSubstr("is damaged: holds more than it says"));
  std::string of_no_array = content;
  of_no_array[0] = 13;
  EXPECT_THAT(error_of_file(header() + packed(of_no_array)), HasSubstr("is damaged: holds no array"));
}

TEST_F(MatlabArrayTest, DamagedPackedBytesAreRefused) {
  std::string values;
  for (int i = 0; i < 6; ++i) values += bytes_of(std::sqrt(static_cast<double>(i)));
  const std::string content = matrix(kFlags + kTwoByThree + kName + tagged(9, values));
  const std::string whole = header() + packed(content);
  put_file(path, whole);
  MatlabArray array(path, "abc");
  EXPECT_EQ(values_of(array, 6).back(), std::sqrt(5.0));
  for (std::size_t place = 136; place < whole.size(); ++place) {
    std::string damaged = whole;
    damaged[place] = static_cast<char>(damaged[place] ^ 0x10);
    if (place == 137) continue;  // zlib's own flags
    EXPECT_THAT(error_of_file(damaged), HasSubstr("a.mat")) << "byte " << place;
  }
  EXPECT_THAT(error_of_file(header() + packed(content + "more")), HasSubstr("more than it says"));
}

TEST_F(MatlabArrayTest, AnotherVersionIsRefused) {
  const std::string array = matrix(kFlags + kTwoByThree + kName + tagged(9, std::string(48, '\0')));
  constexpr const char* kExpected = "a.mat: expected a little-endian Matlab file of version 5";
  put_file(path, header() + array);
  EXPECT_NO_THROW(MatlabArray(path, "abc"));
  EXPECT_THAT(error_of_file(header().substr(0, 127)), HasSubstr(kExpected));
  EXPECT_THAT(error_of_file(std::string(124, ' ') + std::string("\x00\x02IM", 4) + array),
              HasSubstr(kExpected));
  EXPECT_THAT(error_of_file(std::string(124, ' ') + std::string("\x01\x00MI", 4) + array),
              HasSubstr(kExpected));
}

TEST_F(MatlabArrayTest, AsManyValuesAreReadAsThereAre) {
  const std::string bytes =
      header() + matrix(kFlags + kTwoByThree + kName + tagged(9, std::string(48, '\0')));
  EXPECT_THAT(error_of_file(bytes, 7), HasSubstr("has 6 values left, asked for 7"));
  EXPECT_THAT(error_of_file(bytes, 5), HasSubstr("1 of its values were not read"));
}

TEST_F(MatlabArrayTest, ASmallElementHasFourBytesAtMost) {
  std::string name = kName;
  name[2] = 5;
  EXPECT_THAT(
      error_of_file(header() + matrix(kFlags + kTwoByThree + name + tagged(9, std::string(48, '\0')))),
      HasSubstr("is damaged: a small element of 5 bytes"));
}

}  // namespace
}  // namespace knuckle
