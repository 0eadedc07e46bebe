// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_file.h"

#include <cstring>
#include <ctime>
#include <numeric>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/deflate.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

void write_example(const std::filesystem::path& path) {
  Hdf5Writer file = Hdf5Writer::create(path);
  std::vector<float> values(60);
  std::iota(values.begin(), values.end(), 0.5f);
  file.write<float>("values", {5, 4, 3}, values.data(), {1, 4});
  file.set_attribute("format", "knuckle-example");
  file.set_attribute("version", 1);
  file.set_attribute("numbers", std::vector<double>{1.0, 2.5});
  file.close();
}

class Hdf5FileTest : public ::testing::Test {
 protected:
  void SetUp() override { write_example(path); }

  TemporaryFolder folder;
  std::filesystem::path path = folder / "example.h5";
};

TEST_F(Hdf5FileTest, ArraysComeBackWithShapeAndValues) {
  const Hdf5File file = Hdf5File::open(path);
  const auto array = file.read<float>("values");
  EXPECT_THAT(array.shape, ElementsAre(5, 4, 3));
  EXPECT_EQ(array.values[59], 59.5f);
  EXPECT_EQ(file.read<double>("values").values[1], 1.5);
}

/// So that the same content has the same bytes: of an object's header the seconds since 1970 in 32 bits.
TEST_F(Hdf5FileTest, DoNotSayWhenTheyWereMade) {
  const std::string bytes = read_text_file(path);
  const auto now = static_cast<std::uint32_t>(std::time(nullptr));
  for (std::size_t at = 0; at + sizeof(now) <= bytes.size(); ++at) {
    std::uint32_t number = 0;
    std::memcpy(&number, bytes.data() + at, sizeof(number));
    EXPECT_FALSE(number <= now && number > now - 60) << "at byte " << at;
  }
}

TEST_F(Hdf5FileTest, RowsAreThoseOfTheWholeArray) {
  const Hdf5File file = Hdf5File::open(path);
  std::vector<float> rows(24);
  file.read_rows("values", 2, 2, rows.data());
  EXPECT_EQ(rows.front(), 24.5f);
  EXPECT_EQ(rows.back(), 47.5f);
  EXPECT_THAT(error_of([&] { file.read_rows("values", 4, 2, rows.data()); }), HasSubstr("rows 4 to 6"));
}

TEST_F(Hdf5FileTest, RowsWrittenLaterLeaveTheOthersZero) {
  {
    Hdf5Writer file = Hdf5Writer::open(path);
    file.create_dataset<std::uint16_t>("later", {4, 2}, {1, 1});
    const std::uint16_t row[] = {7, 8};
    file.write_rows("later", 2, 1, row);
    file.close();
  }
  EXPECT_THAT(Hdf5File::open(path).read<std::uint16_t>("later").values, ElementsAre(0, 0, 0, 0, 7, 8, 0, 0));
}

TEST_F(Hdf5FileTest, TextsAndAttributesComeBack) {
  const Hdf5File file = Hdf5File::open(path);
  EXPECT_EQ(file.text_attribute("format"), "knuckle-example");
  EXPECT_THAT(file.numbers_attribute("numbers"), ElementsAre(1.0, 2.5));
  EXPECT_EQ(file.require_format("knuckle-example", 1), 1);
}

TEST_F(Hdf5FileTest, ManyThreadsReadAtOnce) {
  const Hdf5File file = Hdf5File::open(path);
  parallel_for(200, [&](std::int64_t i) {
    std::vector<float> row(12);
    file.read_rows("values", static_cast<std::uint64_t>(i % 5), 1, row.data());
    if (row[0] != static_cast<float>(i % 5) * 12 + 0.5f) fail("row {} is wrong", i);
  });
}

TEST_F(Hdf5FileTest, WhatIsMissingOrOfAnotherKindIsNamed) {
  const Hdf5File file = Hdf5File::open(path);
  EXPECT_THAT(error_of([&] { file.read<float>("weights"); }),
              HasSubstr("example.h5: weights: the array is missing"));
  EXPECT_THAT(error_of([&] { file.text_attribute("author"); }), HasSubstr("'author' is missing"));
  EXPECT_THAT(error_of([&] { file.text_attribute("version"); }), HasSubstr("'version' is not text"));
  EXPECT_THAT(error_of([&] { file.number_attribute("format"); }), HasSubstr("'format' is not a number"));
  EXPECT_THAT(error_of([&] { file.number_attribute("numbers"); }), HasSubstr("holds 2 numbers, expected 1"));
}

TEST_F(Hdf5FileTest, AnotherFormatOrVersionIsRefused) {
  EXPECT_THAT(error_of([&] { Hdf5File::open(path).require_format("knuckle-body", 1); }),
              HasSubstr("expected a knuckle-body file, found a knuckle-example file"));
  {
    Hdf5Writer file = Hdf5Writer::open(path);
    file.set_attribute("version", 2);
  }
  EXPECT_THAT(error_of([&] { Hdf5File::open(path).require_format("knuckle-example", 1); }),
              HasSubstr("version 2 is not known"));
}

TEST_F(Hdf5FileTest, WithoutFormatOrVersionItIsNoSuchFile) {
  { Hdf5Writer::create(path); }
  EXPECT_THAT(
      error_of([&] { Hdf5File::open(path).require_format("knuckle-example", 1); }),
      HasSubstr("example.h5: no knuckle-example file: its attributes 'format' and 'version' are missing"));
  {
    Hdf5Writer file = Hdf5Writer::open(path);
    file.set_attribute("format", "knuckle-example");
  }
  EXPECT_THAT(error_of([&] { Hdf5File::open(path).require_format("knuckle-example", 1); }),
              HasSubstr("its attributes 'format' and 'version' are missing"));
}

TEST_F(Hdf5FileTest, AListIsNoNumber) {
  EXPECT_THAT(error_of([&] { Hdf5File::open(path).number_attribute("numbers"); }),
              HasSubstr("example.h5: the attribute 'numbers' holds 2 numbers, expected 1"));
}

TEST_F(Hdf5FileTest, AFileCutShortOrForeignIsRefused) {
  const std::string bytes = read_text_file(path);
  for (const double part : {0.0, 0.001, 0.2, 0.9}) {
    write_text_file(folder / "cut.h5",
                    bytes.substr(0, static_cast<std::size_t>(part * double(bytes.size()))));
    EXPECT_THAT(error_of([&] { Hdf5File::open(folder / "cut.h5"); }), HasSubstr("cut.h5")) << part;
  }
  EXPECT_THAT(error_of([&] { Hdf5File::open(folder / "none.h5"); }),
              HasSubstr("none.h5: the file is missing"));
  EXPECT_THAT(error_of([&] { Hdf5File::open(folder.path()); }), HasSubstr("found a folder"));
}

/// Declares 2^20 times as many rows as the array of 16 x 4 has, by changing the file's bytes.
void declare_huge_array(const std::filesystem::path& path) {
  std::string bytes = read_text_file(path);
  const std::uint64_t extent[] = {16, 4};
  const std::string before(reinterpret_cast<const char*>(extent), sizeof(extent));
  const std::uint64_t huge = std::uint64_t{1} << 40;
  int changed = 0;
  for (std::size_t at = bytes.find(before); at != std::string::npos; at = bytes.find(before, at + 8)) {
    bytes.replace(at, sizeof(huge), reinterpret_cast<const char*>(&huge), sizeof(huge));
    ++changed;
  }
  ASSERT_GT(changed, 0) << "the extent does not stand in the file as expected";
  write_text_file(path, bytes);
}

TEST_F(Hdf5FileTest, AnArrayLargerThanTheFileCanHoldIsRefusedBeforeMemoryIsTaken) {
  for (const Hdf5Writer::Storage& storage : {Hdf5Writer::Storage{0, 0}, Hdf5Writer::Storage{1, 1}}) {
    const std::filesystem::path huge = folder / "huge.h5";
    {
      Hdf5Writer file = Hdf5Writer::create(huge);
      file.write<float>("values", {16, 4}, std::vector<float>(64, 1.5f).data(), storage);
      file.close();
    }
    EXPECT_EQ(Hdf5File::open(huge).read<float>("values").values.size(), 64u);
    ASSERT_NO_FATAL_FAILURE(declare_huge_array(huge));
    const Hdf5File file = Hdf5File::open(huge);
    EXPECT_THAT(error_of([&] { file.read<float>("values"); }),
                AllOf(HasSubstr("huge.h5: values"), HasSubstr("declares 4398046511104 values")));
    EXPECT_THAT(error_of([&] { file.shape("values"); }), HasSubstr("huge.h5: values: declares"));
  }
}

TEST_F(Hdf5FileTest, OfALargeArrayWhatItsChunksHoldIsCountedAndNoMore) {
  constexpr std::size_t kRows = 80;  // of a mebibyte each: more than may be left unwritten
  const std::vector<std::uint8_t> row(std::size_t{1} << 20, 7);
  const auto write_rows = [&](const std::filesystem::path& to, std::size_t count) {
    Hdf5Writer file = Hdf5Writer::create(to);
    file.create_dataset<std::uint8_t>("rows", {kRows, row.size()}, {1, 1});
    const std::vector<std::uint8_t> chunk = deflated(row);
    for (std::size_t i = 0; i < count; ++i) file.write_chunk("rows", i, chunk);
    file.close();
  };
  write_rows(folder / "whole.h5", kRows);
  std::vector<std::uint8_t> back(row.size());
  Hdf5File::open(folder / "whole.h5").read_rows("rows", kRows - 1, 1, back.data());
  EXPECT_EQ(back, row);

  write_rows(folder / "hardly.h5", 1);
  const Hdf5File hardly = Hdf5File::open(folder / "hardly.h5");
  EXPECT_THAT(error_of([&] { hardly.read_rows("rows", 0, 1, back.data()); }),
              AllOf(HasSubstr("hardly.h5: rows"), HasSubstr("declares")));
}

TEST_F(Hdf5FileTest, ChunksThatOthersCompressedAreRead) {
  const std::vector<std::uint16_t> row{7, 7, 7, 7, 300, 0, 65535, 7};
  {
    Hdf5Writer file = Hdf5Writer::open(path);
    file.create_dataset<std::uint16_t>("rows", {3, 8}, {1, 1});
    file.write_chunk("rows", 1, deflated(shuffled(row)));
    file.close();
  }
  std::vector<std::uint16_t> back(8);
  Hdf5File::open(path).read_rows("rows", 1, 1, back.data());
  EXPECT_EQ(back, row);
}

TEST_F(Hdf5FileTest, ChunksOfAnotherSizeAreRefused) {
  constexpr std::uint64_t kRow = std::uint64_t{1} << 16;
  {
    Hdf5Writer file = Hdf5Writer::open(path);
    file.create_dataset<std::uint8_t>("deflated", {2, kRow}, {1, 1});
    file.write_chunk("deflated", 0, std::vector<std::uint8_t>(3));
    file.create_dataset<std::uint8_t>("plain", {2, kRow}, {1, 0});
    file.write_chunk("plain", 0, std::vector<std::uint8_t>(3));
    file.close();
  }
  const Hdf5File file = Hdf5File::open(path);
  std::vector<std::uint8_t> row(kRow);
  EXPECT_THAT(error_of([&] { file.read_rows("deflated", 0, 1, row.data()); }),
              HasSubstr("example.h5: deflated: a chunk is smaller than it may be"));
  EXPECT_THAT(error_of([&] { file.read_rows("plain", 0, 1, row.data()); }),
              HasSubstr("example.h5: plain: a chunk has another size"));
}

TEST_F(Hdf5FileTest, WhatCannotBeWrittenIsNamed) {
  Hdf5Writer file = Hdf5Writer::open(path);
  const std::vector<float> row(12);
  EXPECT_THAT(error_of([&] { file.write_rows("weights", 0, 1, row.data()); }),
              HasSubstr("example.h5: weights: the array is missing"));
  EXPECT_THAT(error_of([&] { file.write_rows("values", 5, 1, row.data()); }),
              HasSubstr("example.h5: values: has no rows 5 to 6"));
  EXPECT_THAT(error_of([&] { file.write_rows("values", 0, 6, row.data()); }),
              HasSubstr("has no rows 0 to 6"));
  EXPECT_THAT(error_of([&] { file.create_dataset<float>("values", {5}, {}); }),
              HasSubstr("example.h5: values: the array cannot be made"));
  file.create_dataset<float>("one", {}, {});
  EXPECT_THAT(error_of([&] { file.write_rows("one", 0, 1, row.data()); }),
              HasSubstr("one: has no rows 0 to 1"));
  EXPECT_THAT(error_of([&] { file.write_chunk("one", 0, std::vector<std::uint8_t>(4)); }),
              HasSubstr("example.h5: one: has no rows"));
  EXPECT_THAT(error_of([&] { file.write_chunk("values", 7, std::vector<std::uint8_t>(4)); }),
              HasSubstr("example.h5: values: cannot be written"));
  EXPECT_THAT(error_of([&] { file.set_attribute("", 1.0); }),
              HasSubstr("example.h5: cannot write the attribute ''"));
  EXPECT_THAT(error_of([&] { Hdf5Writer::open(folder / "none.h5"); }),
              HasSubstr("none.h5: the HDF5 file is missing, damaged, or in use"));
}

TEST_F(Hdf5FileTest, AnUnwritablePlaceIsNamed) {
  EXPECT_THAT(error_of([] { Hdf5Writer::create("/proc/knuckle.h5"); }),
              HasSubstr("/proc/knuckle.h5: cannot write"));
}

}  // namespace
}  // namespace knuckle
