// SPDX-License-Identifier: Apache-2.0
// Files whose bytes were changed. Under the sanitizers each of these tests sees far more.
#include <array>
#include <cstring>
#include <fstream>
#include <numeric>
#include <stdexcept>

#include "knuckle/core/error.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/hdf5/hdf5_file.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

class DamagedHdf5 : public ::testing::Test {
 protected:
  DamagedHdf5() {
    Hdf5Writer file = Hdf5Writer::create(path_);
    std::vector<float> values(200);
    std::iota(values.begin(), values.end(), 0.5F);
    file.write<float>("depth", {20, 5, 2}, values.data(), {1, 4});
    file.write<float>("whole", {20, 5, 2}, values.data());
    file.set_attribute("format", "knuckle-example");
    file.set_attribute("numbers", std::vector<double>{1.0, 2.5});
    file.close();
    bytes_ = read_text_file(path_);
  }

  /// Reads all that the file has. Whatever its bytes are, this ends, with all or with an Error of one line.
  std::string fault_of(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary) << bytes;
    return fault_of_file();
  }
  std::string fault_of_file() const {
    try {
      const Hdf5File file = Hdf5File::open(path_);
      for (const char* name : {"depth", "whole"}) {
        if (file.has(name)) (void)file.read<float>(name);
      }
      if (file.has_attribute("format")) (void)file.text_attribute("format");
      if (file.has_attribute("numbers")) (void)file.numbers_attribute("numbers");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  std::size_t place_of(std::string_view text, std::size_t from = 0) const {
    const std::size_t place = bytes_.find(text, from);
    EXPECT_NE(place, std::string::npos) << text;
    return place;
  }
  /// Where the layout of the array in chunks of 1 x 5 x 2 floats is told: version, kind, dimensions, tree,
  /// sides.
  std::size_t chunk_layout() const {
    std::string sides(16, '\0');
    for (const auto& [i, side] : {std::pair{0, 1}, {1, 5}, {2, 2}, {3, 4}})
      put(sides, 4 * static_cast<std::size_t>(i), static_cast<std::uint64_t>(side), 4);
    return place_of(sides) - 3 - 8;
  }
  /// The header of the array that is the first or the second by its name.
  std::size_t array_header(std::size_t array) const {
    constexpr std::size_t kHead = 8;
    constexpr std::size_t kEntry = 40;
    return number_at(place_of("SNOD") + kHead + array * kEntry + 8, 8);
  }
  std::size_t root_header() const { return number_at(64, 8); }
  /// What the first message of that type says; its flags are four bytes before.
  std::size_t message(std::size_t header, std::uint64_t type) const {
    constexpr std::uint64_t kContinuation = 0x10;
    constexpr std::size_t kHead = 8;
    std::vector<std::pair<std::size_t, std::size_t>> blocks{{header + 16, number_at(header + 8, 4)}};
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const auto [begin, size] = blocks[i];
      for (std::size_t place = begin; place + kHead <= begin + size;
           place += kHead + number_at(place + 2, 2)) {
        if (number_at(place, 2) == type) return place + kHead;
        if (number_at(place, 2) == kContinuation)
          blocks.emplace_back(number_at(place + kHead, 8), number_at(place + kHead + 8, 8));
      }
    }
    throw std::runtime_error(fmt::format("no message of type {}", type));
  }
  std::uint64_t number_at(std::size_t place, std::size_t size) const {
    std::uint64_t number = 0;
    std::memcpy(&number, bytes_.substr(place, size).data(), size);
    return number;
  }
  /// What is wrong with the file once another number lies at that place.
  std::string fault_with(std::size_t place, std::uint64_t number, std::size_t size) {
    std::string bytes = bytes_;
    put(bytes, place, number, size);
    return fault_of(bytes);
  }
  static std::string address_text(std::uint64_t address) {
    std::string text(8, '\0');
    put(text, 0, address, 8);
    return text;
  }
  /// With a tree of 200 levels in place of another one, each of whose nodes leads twice to the one below, to
  /// an empty one in the end: 2^200 visits. `told` is where the file says where the tree is.
  std::string with_nest_for(std::size_t tree, std::size_t told, std::uint64_t kind,
                            std::size_t key_bytes) const {
    EXPECT_NE(tree, told);
    std::string bytes = bytes_;
    put(bytes, told, bytes.size(), 8);
    for (std::uint64_t level = 201; level-- > 0;) {
      std::string node(24 + 3 * key_bytes + 16, '\0');
      std::memcpy(node.data(), "TREE", 4);
      put(node, 4, kind, 1);
      put(node, 5, level, 1);
      put(node, 6, level > 0 ? 2 : 0, 2);
      const std::uint64_t below = bytes.size() + node.size();
      put(node, 24 + key_bytes, below, 8);
      put(node, 24 + 2 * key_bytes + 8, below, 8);
      bytes += node;
    }
    put(bytes, 40, bytes.size(), 8);  // the file's end
    return bytes;
  }
  static void put(std::string& bytes, std::size_t place, std::uint64_t number, std::size_t size) {
    std::memcpy(bytes.data() + place, &number, size);
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "damaged.h5";
  std::string bytes_;
};

TEST_F(DamagedHdf5, EndsWithAllOrWithAnErrorThatNamesTheFile) {
  ASSERT_EQ(fault_of(bytes_), "");
  Random random(1, 0);
  int refused = 0;
  for (int i = 0; i < 1500; ++i) {
    std::string bytes = bytes_;
    const std::uint32_t changes = 1 + random.below(3);
    for (std::uint32_t k = 0; k < changes; ++k) {
      constexpr std::array<std::uint8_t, 5> kLikely{0, 1, 0x7f, 0x80, 0xff};
      const std::uint32_t kind = random.below(6);
      bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] =
          static_cast<char>(kind < 5 ? kLikely[kind] : random.below(256));
    }
    std::ofstream(path_, std::ios::binary) << bytes;
    const std::string fault = fault_of_file();
    if (fault.empty()) continue;
    ++refused;
    ASSERT_THAT(fault, HasSubstr("damaged.h5"));
  }
  EXPECT_GT(refused, 40);
}

TEST_F(DamagedHdf5, CutAtAnyPlaceIsRefused) {
  for (std::size_t size = 0; size < bytes_.size(); size += 37) {
    ASSERT_THAT(fault_of(bytes_.substr(0, size)), HasSubstr("damaged.h5")) << size;
  }
}

TEST_F(DamagedHdf5, ATreeThatLeadsBackToItselfEnds) {
  // The only node of the chunks' tree becomes its own child: first of its own level, then a leaf.
  std::size_t tree = place_of("TREE");
  while (bytes_[tree + 4] != 1) tree = place_of("TREE", tree + 1);
  constexpr std::size_t kFirstChild = 24 + 8 + 8 * 4;
  std::string bytes = bytes_;
  put(bytes, tree + 5, 1, 1);
  put(bytes, tree + kFirstChild, tree, 8);
  EXPECT_THAT(fault_of(bytes), HasSubstr("a tree's node is of another level"));
}

TEST_F(DamagedHdf5, NodesThatAreVisitedAgainAndAgainEnd) {
  std::size_t chunks = place_of("TREE");
  while (bytes_[chunks + 4] != 1) chunks = place_of("TREE", chunks + 1);
  const std::string no_chunks = with_nest_for(chunks, place_of(address_text(chunks)), 1, 8 + 8 * 4);
  EXPECT_THAT(fault_of(no_chunks), HasSubstr("chunks are not in order"));

  std::size_t links = place_of("TREE");
  while (bytes_[links + 4] != 0) links = place_of("TREE", links + 1);
  constexpr std::size_t kSuperblock = 96;  // has the root's tree once more, which nobody asks for
  const std::string no_links = with_nest_for(links, place_of(address_text(links), kSuperblock), 0, 8);
  EXPECT_THAT(fault_of(no_links), HasSubstr("a tree has more nodes than the file can hold"));

  std::string of_wrong_levels = no_links;
  const std::size_t second = bytes_.size() + 24 + 3 * 8 + 16;
  of_wrong_levels[second + 5] = 7;
  EXPECT_THAT(fault_of(of_wrong_levels), HasSubstr("a tree's node is of another level"));
}

TEST_F(DamagedHdf5, AHeaderThatContinuesInItselfEnds) {
  // The root's header is changed into a message that continues at the header's own messages.
  const std::string continuation("\x10\0\x10\0\0\0\0\0", 8);
  std::uint64_t root = 0;
  std::memcpy(&root, bytes_.data() + 64, 8);
  std::string bytes = bytes_;
  bytes.replace(root + 16, 8, continuation);
  put(bytes, root + 24, root + 16, 8);
  put(bytes, root + 32, 24, 8);
  EXPECT_THAT(fault_of(bytes), HasSubstr("an object's header has more than 16777216 bytes"));
}

TEST_F(DamagedHdf5, AnObjectWithoutAHeaderIsRefused) {
  std::uint64_t root = 0;
  std::memcpy(&root, bytes_.data() + 64, 8);
  std::string bytes = bytes_;
  put(bytes, root, 3, 1);
  EXPECT_THAT(fault_of(bytes), HasSubstr("an object has no header"));
}

TEST_F(DamagedHdf5, AFileThatSaysThatItIsLongerIsCutShort) {
  std::string bytes = bytes_;
  put(bytes, 40, bytes_.size() + 1, 8);
  EXPECT_THAT(fault_of(bytes),
              HasSubstr(fmt::format("has {} bytes, expected {}", bytes_.size(), bytes_.size() + 1)));
}

TEST_F(DamagedHdf5, NamesLieWithinTheirHeapAndEnd) {
  const std::size_t heap = place_of("HEAP");
  std::string endless = bytes_;
  std::uint64_t names = 0;
  std::uint64_t length = 0;
  std::memcpy(&length, bytes_.data() + heap + 8, 8);
  std::memcpy(&names, bytes_.data() + heap + 24, 8);
  std::fill_n(endless.begin() + static_cast<std::ptrdiff_t>(names), length, 'x');
  EXPECT_THAT(fault_of(endless), HasSubstr("a name does not end"));
  std::string long_heap = bytes_;
  put(long_heap, heap + 8, (std::uint64_t{16} << 20) + 1, 8);
  EXPECT_THAT(fault_of(long_heap), HasSubstr("a group has more names than it may"));
  std::string outside = bytes_;
  put(outside, place_of("SNOD") + 8, length, 8);
  EXPECT_THAT(fault_of(outside), HasSubstr("a name lies outside of its heap"));
}

TEST_F(DamagedHdf5, AGroupHasNoMoreLinksThanTheFileCanHold) {
  std::string bytes = bytes_;
  put(bytes, place_of("SNOD") + 6, 0xffff, 2);
  EXPECT_THAT(fault_of(bytes), HasSubstr("a group has more links than the file can hold"));
}

TEST_F(DamagedHdf5, FiltersOfAnUnknownVersionAreRefused) {
  const std::size_t filters = place_of("shuffle") - 16;
  ASSERT_EQ(bytes_.substr(filters, 2), "\1\2") << "version 1, shuffle and deflate";
  for (const std::uint64_t version : {0, 3}) {
    std::string bytes = bytes_;
    put(bytes, filters, version, 1);
    EXPECT_THAT(fault_of(bytes), HasSubstr("depth: its filters are of an unknown version")) << version;
  }
}

TEST_F(DamagedHdf5, AChunkThatIsNotAsLongAsAllIsRefused) {
  std::size_t tree = place_of("TREE");
  while (bytes_[tree + 4] != 1) tree = place_of("TREE", tree + 1);
  std::string bytes = bytes_;
  put(bytes, tree + 24 + 4, 2, 4);  // says that its chunk is not compressed
  EXPECT_THAT(fault_of(bytes), HasSubstr("depth: a chunk has another size"));
}

TEST_F(DamagedHdf5, ChunksOfOtherNumbersAreRefused) {
  std::string bytes = bytes_;
  const std::size_t layout = chunk_layout();
  put(bytes, layout + 3 + 8 + 3 * 4, 8, 4);
  EXPECT_THAT(fault_of(bytes), HasSubstr("depth: its chunks hold other numbers"));
}

/// Each of its 20 rows would cost 40,000 bytes, filled or inflated, of which 40 are read.
TEST_F(DamagedHdf5, ChunksFarLargerThanTheArrayAreRefused) {
  std::string bytes = bytes_;
  put(bytes, chunk_layout() + 3 + 8 + 4, 5000, 4);
  EXPECT_THAT(fault_of(bytes), HasSubstr("depth: holds 800000 bytes in chunks for 800"));
  put(bytes, chunk_layout() + 3 + 8 + 4, 80, 4);  // sixteen times is as it may be: a set that grows later
  EXPECT_THAT(fault_of(bytes), ::testing::Not(HasSubstr("in chunks for")));
}

TEST_F(DamagedHdf5, FiltersMakeNoMoreOfWhatLiesInTheHeader) {
  // The array that was in compressed chunks is now in the header, where ten bytes are ten bytes.
  std::string bytes = bytes_;
  const std::size_t layout = chunk_layout();
  put(bytes, layout + 1, 0, 1);
  put(bytes, layout + 2, 10, 2);
  EXPECT_THAT(fault_of(bytes), HasSubstr("depth: declares 200 values"));
}

TEST_F(DamagedHdf5, AChunkThatIsThereTwiceIsRefused) {
  std::size_t tree = place_of("TREE");
  while (bytes_[tree + 4] != 1) tree = place_of("TREE", tree + 1);
  constexpr std::size_t kKey = 8 + 8 * 4;
  std::string bytes = bytes_;
  bytes.replace(tree + 24 + kKey + 8, kKey, bytes_, tree + 24, kKey);
  EXPECT_THAT(fault_of(bytes), HasSubstr("chunks are not in order"));
}

// The types of messages.
constexpr std::uint64_t kShape = 0x01;
constexpr std::uint64_t kType = 0x03;
constexpr std::uint64_t kFillValue = 0x05;
constexpr std::uint64_t kLayout = 0x08;
constexpr std::uint64_t kFilters = 0x0B;
constexpr std::uint64_t kAttribute = 0x0C;
constexpr std::uint64_t kSymbolTable = 0x11;

constexpr std::uint64_t kUndefined = ~std::uint64_t{0};

TEST_F(DamagedHdf5, ASuperblockThatCannotBeReadIsNamed) {
  EXPECT_THAT(fault_with(0, 0, 1), HasSubstr("no HDF5 file, or its beginning is damaged"));
  EXPECT_THAT(fault_with(8, 4, 1), HasSubstr("has a superblock of version 4, which is not read"));
  EXPECT_THAT(fault_with(13, 3, 1), HasSubstr("addresses of 3 bytes, lengths of 8"));
  EXPECT_THAT(fault_with(14, 16, 1), HasSubstr("addresses of 8 bytes, lengths of 16"));
  EXPECT_THAT(fault_with(40, kUndefined, 8), HasSubstr("an address is missing"));
  EXPECT_THAT(fault_with(64, bytes_.size() + 1, 8), HasSubstr("lie beyond its end"));
  const std::string all = std::to_string(bytes_.size());
  EXPECT_THAT(
      fault_of(bytes_.substr(0, bytes_.size() - 1)),
      HasSubstr("is cut short: it has " + std::to_string(bytes_.size() - 1) + " bytes, expected " + all));
}

TEST_F(DamagedHdf5, AGroupThatCannotBeReadIsNamed) {
  EXPECT_THAT(fault_with(root_header(), 2, 1), HasSubstr("an object has no header"));
  const std::size_t table = message(root_header(), kSymbolTable);
  EXPECT_THAT(fault_with(table, kUndefined, 8), HasSubstr("an address is missing"));
  const std::size_t tree = number_at(table, 8);
  EXPECT_THAT(fault_with(tree + 4, 1, 1), HasSubstr("a tree is of another kind"));
  EXPECT_THAT(fault_with(tree + 6, 65535, 2), HasSubstr("a tree has more nodes than the file can hold"));
  EXPECT_THAT(fault_with(tree, 'X', 1), HasSubstr("a structure does not begin with TREE"));
  const std::size_t symbols = place_of("SNOD");
  EXPECT_THAT(fault_with(symbols, 'X', 1), HasSubstr("a structure does not begin with SNOD"));
  EXPECT_THAT(fault_with(symbols + 6, 65535, 2), HasSubstr("a group has more links than the file can hold"));
}

/// Each of the tree's entries leads to the same node of symbols, which the file holds once.
TEST_F(DamagedHdf5, SymbolsThatAreNamedAgainAndAgainEnd) {
  const std::size_t table = message(root_header(), kSymbolTable);
  constexpr std::uint64_t kEntries = 60;
  std::string node(24, '\0');
  std::memcpy(node.data(), "TREE", 4);
  put(node, 6, kEntries, 2);
  const std::string entry = std::string(8, '\0') + address_text(place_of("SNOD"));
  for (std::uint64_t i = 0; i < kEntries; ++i) node += entry;
  node += std::string(8, '\0');
  std::string bytes = bytes_;
  put(bytes, table, bytes.size(), 8);
  bytes += node;
  const std::size_t symbols = place_of("SNOD");
  put(bytes, symbols + 6, 8, 2);
  put(bytes, 40, bytes.size(), 8);
  EXPECT_THAT(fault_of(bytes), HasSubstr("a group has more links than the file can hold"));
}

TEST_F(DamagedHdf5, NamesThatAreNotInTheirHeapAreRefused) {
  const std::size_t heap = place_of("HEAP");
  const std::size_t first_name = place_of("SNOD") + 8;
  const std::uint64_t names_bytes = number_at(heap + 8, 8);
  const std::size_t names = number_at(heap + 24, 8);
  EXPECT_THAT(fault_with(heap, 'X', 1), HasSubstr("a structure does not begin with HEAP"));
  EXPECT_THAT(fault_with(heap + 8, 1 << 25, 8), HasSubstr("a group has more names than it may"));
  EXPECT_THAT(fault_with(first_name, names_bytes, 8), HasSubstr("a name lies outside of its heap"));
  std::string bytes = bytes_;
  put(bytes, first_name, names_bytes - 1, 8);
  put(bytes, names + names_bytes - 1, 'x', 1);
  EXPECT_THAT(fault_of(bytes), HasSubstr("a name does not end"));
}

TEST_F(DamagedHdf5, AttributesThatCannotBeReadAreNamed) {
  const std::size_t attribute = message(root_header(), kAttribute);
  EXPECT_THAT(fault_with(attribute, 4, 1), HasSubstr("an attribute is of an unknown version"));
  EXPECT_THAT(fault_with(attribute, 0, 1), HasSubstr("an attribute is of an unknown version"));
  EXPECT_THAT(fault_with(attribute - 4, 2, 1), HasSubstr("has a shared attribute, which is not read"));
  // The list of two numbers is said to have three. Its shape ends with its number of values, twice or once.
  const std::size_t list = place_of(std::string("numbers\0", 8));
  const std::size_t sides = place_of(address_text(2), list);
  EXPECT_THAT(fault_with(sides, 3, 8), HasSubstr("the attribute 'numbers' declares 24 bytes and has 16"));
}

TEST_F(DamagedHdf5, ShapesThatCannotBeReadAreNamed) {
  const std::size_t shape = message(array_header(1), kShape);
  EXPECT_THAT(fault_with(shape, 3, 1), HasSubstr("a shape is of an unknown version"));
  EXPECT_THAT(fault_with(shape + 1, 32, 1), HasSubstr("a structure ends too early"));
  EXPECT_THAT(fault_with(shape + 1, 33, 1), HasSubstr("a shape has too many dimensions"));
  EXPECT_THAT(fault_with(shape + 1, 0, 1), HasSubstr("whole: expected an array, found a single number"));
}

TEST_F(DamagedHdf5, WhatAnArrayLacksIsNamed) {
  const std::size_t whole = array_header(1);
  constexpr std::uint64_t kNothing = 0;
  const auto fault_without = [&](std::uint64_t type) {
    return fault_with(message(whole, type) - 8, kNothing, 2);
  };
  EXPECT_THAT(fault_without(kShape), HasSubstr("whole: expected an array"));
  EXPECT_THAT(fault_without(kType), HasSubstr("whole: expected an array"));
  EXPECT_THAT(fault_without(kLayout), HasSubstr("whole: expected an array"));
  const auto fault_shared = [&](std::uint64_t type) { return fault_with(message(whole, type) - 4, 2, 1); };
  EXPECT_THAT(fault_shared(kShape), HasSubstr("whole: expected an array of numbers, found a named type"));
  EXPECT_THAT(fault_shared(kType), HasSubstr("whole: expected an array of numbers, found a named type"));
  EXPECT_THAT(fault_shared(kLayout), HasSubstr("whole: expected an array"));
  EXPECT_THAT(fault_with(message(whole, kType) + 4, 3, 4),
              HasSubstr("whole: expected an array of numbers: "));
}

TEST_F(DamagedHdf5, FillValuesThatCannotBeReadAreNamed) {
  const std::size_t fill = message(array_header(1), kFillValue);
  EXPECT_THAT(fault_with(fill, 0, 1), HasSubstr("whole: its fill value is of an unknown version"));
  EXPECT_THAT(fault_with(fill, 4, 1), HasSubstr("whole: its fill value is of an unknown version"));
  EXPECT_THAT(fault_with(fill - 4, 2, 1), HasSubstr("whole: its fill value is of an unknown version"));
  std::string bytes = bytes_;
  put(bytes, fill, 2, 1);
  put(bytes, fill + 3, 1, 1);
  put(bytes, fill + 4, 3, 4);
  EXPECT_THAT(fault_of(bytes), HasSubstr("whole: its fill value is of another type; the file is damaged"));
}

TEST_F(DamagedHdf5, LayoutsThatCannotBeReadAreNamed) {
  const std::size_t layout = message(array_header(1), kLayout);
  EXPECT_THAT(fault_with(layout, 2, 1), HasSubstr("has 'whole' in a layout of version 2, which is not read"));
  EXPECT_THAT(fault_with(layout, 5, 1), HasSubstr("has 'whole' in a layout of version 5, which is not read"));
  EXPECT_THAT(fault_with(layout + 1, 3, 1),
              HasSubstr("whole: has a layout of the unknown kind 3; the file is damaged"));
  EXPECT_THAT(fault_with(layout + 2, bytes_.size() + 1, 8),
              HasSubstr("whole: lies beyond the file's end; it is damaged"));
  EXPECT_THAT(fault_with(layout + 2, bytes_.size() - 799, 8), HasSubstr("800 bytes at"));
  std::string as_virtual = bytes_;
  put(as_virtual, layout, 4, 1);
  put(as_virtual, layout + 1, 3, 1);
  EXPECT_THAT(fault_of(as_virtual), HasSubstr("whole: is stored in another file; expected all in this one"));
}

TEST_F(DamagedHdf5, ChunksOfAnotherShapeAreRefused) {
  const std::size_t layout = chunk_layout();
  EXPECT_THAT(fault_with(layout + 2, 3, 1), HasSubstr("depth: its chunks have another shape"));
  EXPECT_THAT(fault_with(message(array_header(0), kShape) + 1, 0, 1),
              HasSubstr("depth: its chunks have another shape"));
  EXPECT_THAT(fault_with(layout + 3 + 8, 0, 4), HasSubstr("depth: is stored in chunks of 0 bytes"));
}

TEST_F(DamagedHdf5, FiltersThatCannotBeReadAreNamed) {
  const std::size_t filters = message(array_header(0), kFilters);
  EXPECT_THAT(fault_with(filters, 0, 1), HasSubstr("depth: its filters are of an unknown version"));
  EXPECT_THAT(fault_with(filters, 3, 1), HasSubstr("depth: its filters are of an unknown version"));
  EXPECT_THAT(fault_with(filters - 4, 2, 1), HasSubstr("depth: its filters are of an unknown version"));
  EXPECT_THAT(fault_with(filters + 8, 3, 2), HasSubstr("depth: is stored with the filter 3"));
  EXPECT_THAT(fault_with(filters + 8, 1, 2), HasSubstr("depth: is stored with the filter 1"));  // twice
}

TEST_F(DamagedHdf5, ChunksThatCannotBeTheirsAreRefused) {
  const std::size_t tree = number_at(chunk_layout() + 3, 8);
  const std::size_t key = tree + 24;  // of the first chunk: its size, filters left out, place, and address
  EXPECT_THAT(fault_with(key, 8192, 4), HasSubstr("depth: a chunk is larger than it may be"));
  EXPECT_THAT(fault_with(key, 5, 4), HasSubstr("depth: a chunk cannot be inflated"));
  EXPECT_THAT(fault_with(key + 4, 2, 4), HasSubstr("depth: a chunk has another size"));
  EXPECT_THAT(fault_with(key + 4, 3, 4), HasSubstr("depth: a chunk has another size"));
  EXPECT_THAT(fault_with(key + 8 + 8, 1, 8), HasSubstr("a chunk lies between the places of chunks"));
}

TEST_F(DamagedHdf5, AFileThatShrinksWhileItIsReadIsRefused) {
  const Hdf5File file = Hdf5File::open(path_);
  ASSERT_EQ(file.shape("whole")[0], 20U);
  std::filesystem::resize_file(path_, 900);
  EXPECT_THAT(error_of([&] { file.read<float>("whole"); }), HasSubstr("was changed while it was read"));
}

}  // namespace
}  // namespace knuckle
