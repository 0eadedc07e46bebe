// SPDX-License-Identifier: Apache-2.0
// Arrays of many chunks, whose trees have leaves that are read one at a time.
#include <array>
#include <cstring>
#include <fstream>

#include "knuckle/core/parallel.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/hdf5/hdf5_file.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

constexpr std::uint64_t kManyRows =
    5000;  // of the library's usual leaves, which have 64 entries at most, over 78
constexpr std::size_t kNodeHead = 24;
constexpr std::size_t kChunkKey = 8 + 8 * 3;

class ManyChunks : public ::testing::Test {
 protected:
  ManyChunks() {
    Hdf5Writer file = Hdf5Writer::create(path_);
    file.create_dataset<std::int32_t>("numbers", {kManyRows, 2}, {1, 1});
    for (std::uint64_t row = 0; row < kManyRows; ++row) {
      if (!is_written(row)) continue;
      const std::array<std::int32_t, 2> numbers = numbers_of(row);
      file.write_rows("numbers", row, 1, numbers.data());
    }
    file.close();
  }

  /// All but the first, the last, and a few between.
  static bool is_written(std::uint64_t row) { return row > 2 && row + 3 < kManyRows && row % 97 != 5; }
  static std::array<std::int32_t, 2> numbers_of(std::uint64_t row) {
    return {static_cast<std::int32_t>(3 * row) + 1, -static_cast<std::int32_t>(row)};
  }
  static void expect_row(const Hdf5File& file, std::uint64_t row) {
    std::array<std::int32_t, 2> numbers{};
    file.read_rows("numbers", row, 1, numbers.data());
    EXPECT_EQ(numbers, is_written(row) ? numbers_of(row) : (std::array<std::int32_t, 2>{})) << row;
  }

  /// The first node of that level of the chunks' tree.
  static std::size_t node_of_level(const std::string& bytes, int level) {
    std::size_t node = bytes.find("TREE");
    while (bytes[node + 4] != 1 || bytes[node + 5] != level) node = bytes.find("TREE", node + 1);
    return node;
  }
  void change(const std::string& bytes) const { write_text_file(path_, bytes); }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "many.h5";
};

TEST_F(ManyChunks, AreFoundInAnyOrder) {
  const Hdf5File file = Hdf5File::open(path_);
  for (std::uint64_t row = 0; row < kManyRows; ++row) expect_row(file, row);
  Random random(3, 0);
  for (int i = 0; i < 2000; ++i) expect_row(file, random.below(static_cast<std::uint32_t>(kManyRows)));
  const auto all = file.read<std::int32_t>("numbers").values;
  for (std::uint64_t row = 0; row < kManyRows; ++row)
    EXPECT_EQ(all[2 * row], is_written(row) ? numbers_of(row)[0] : 0);
}

TEST_F(ManyChunks, AreFoundByManyThreadsAtOnce) {
  const Hdf5File file = Hdf5File::open(path_);
  parallel_for(4, [&](std::int64_t thread) {
    Random random(4, static_cast<std::uint64_t>(thread));
    for (int i = 0; i < 1000; ++i) expect_row(file, random.below(static_cast<std::uint32_t>(kManyRows)));
  });
}

/// No chunk that is there may pass for one that was never written.
TEST_F(ManyChunks, OfExchangedLeavesAreRefused) {
  std::string bytes = read_text_file(path_);
  const std::size_t parent = node_of_level(bytes, 1);
  std::uint64_t row = 0;  // the first in the first of the leaves
  std::memcpy(&row, bytes.data() + parent + kNodeHead + 8, 8);
  const std::string first = bytes.substr(parent + kNodeHead + kChunkKey, 8);
  bytes.replace(parent + kNodeHead + kChunkKey, 8, bytes, parent + kNodeHead + 2 * kChunkKey + 8, 8);
  bytes.replace(parent + kNodeHead + 2 * kChunkKey + 8, 8, first);
  change(bytes);
  const Hdf5File file = Hdf5File::open(path_);
  std::array<std::int32_t, 2> numbers{};
  EXPECT_THAT(error_of([&] { file.read_rows("numbers", row, 1, numbers.data()); }),
              HasSubstr("many.h5: the HDF5 file is damaged: chunks are not in order"));
  EXPECT_THAT(error_of([&] { file.read<std::int32_t>("numbers"); }), HasSubstr("chunks are not in order"));
  std::uint64_t next = 0;  // the first in the second
  std::memcpy(&next, bytes.data() + parent + kNodeHead + kChunkKey + 8 + 8, 8);
  EXPECT_THAT(error_of([&] { file.read_rows("numbers", next, 1, numbers.data()); }),
              HasSubstr("chunks are not in order"));
  expect_row(file, (row + kManyRows / 2) % kManyRows);  // in another leaf, which nothing is wrong with
}

TEST_F(ManyChunks, OfAParentThatNamesTheSameLeafTwiceAreRefused) {
  std::string bytes = read_text_file(path_);
  const std::size_t parent = node_of_level(bytes, 1);
  bytes.replace(parent + kNodeHead + kChunkKey + 8, kChunkKey + 8, bytes, parent + kNodeHead, kChunkKey + 8);
  change(bytes);
  EXPECT_THAT(error_of([&] { Hdf5File::open(path_).read<std::int32_t>("numbers"); }),
              HasSubstr("chunks are not in order"));
}

TEST_F(ManyChunks, BesideTheArrayDoNotCountAsStored) {
  // The array is said to have three rows of six million columns: what else is stored does not make it so.
  std::string bytes = read_text_file(path_);
  const std::array<std::uint64_t, 2> shape{kManyRows, 2};
  const std::string extent(reinterpret_cast<const char*>(shape.data()), sizeof(shape));
  const std::array<std::uint64_t, 2> other{3, 5'800'000};
  const std::size_t place = bytes.find(extent);
  ASSERT_NE(place, std::string::npos);
  std::memcpy(bytes.data() + place, other.data(), sizeof(other));
  change(bytes);
  EXPECT_THAT(error_of([&] { Hdf5File::open(path_).read<std::int32_t>("numbers"); }), HasSubstr("declares"));
}

TEST_F(ManyChunks, OfAChildThatIsNoLeafAreRefused) {
  std::string bytes = read_text_file(path_);
  bytes[node_of_level(bytes, 0) + 5] = 1;
  change(bytes);
  EXPECT_THAT(error_of([&] { Hdf5File::open(path_).read<std::int32_t>("numbers"); }),
              HasSubstr("a tree's node is of another level"));
}

TEST(ChunksOfManyRows, AreUnpackedOnceForRowsThatFollowOneAnother) {
  const testing::TemporaryFolder folder;
  const std::filesystem::path path = folder / "a.h5";
  std::vector<std::int32_t> numbers(4 * 1000);
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<std::int32_t>(i);
  Hdf5Writer writer = Hdf5Writer::create(path);
  writer.write("numbers", {4, 1000}, numbers.data(), {2, 6});
  writer.close();
  const Hdf5File file = Hdf5File::open(path);
  std::vector<std::int32_t> row(1000);
  file.read_rows("numbers", 0, 1, row.data());
  // What is not read again shows where the file is nothing any more.
  std::ofstream(path, std::ios::binary | std::ios::in) << std::string(std::filesystem::file_size(path), 'x');
  file.read_rows("numbers", 1, 1, row.data());
  EXPECT_EQ(row.front(), 1000);
  EXPECT_EQ(row.back(), 1999);
  EXPECT_THAT(error_of([&] { file.read_rows("numbers", 2, 1, row.data()); }), HasSubstr("a.h5"));
}

}  // namespace
}  // namespace knuckle
