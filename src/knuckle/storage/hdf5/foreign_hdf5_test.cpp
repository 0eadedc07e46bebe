// SPDX-License-Identifier: Apache-2.0
// HDF5 files as others write them, some of them on purpose: made with the library itself.
#include <array>
#include <numeric>

#include <hdf5.h>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/hdf5/hdf5_file.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::SizeIs;

/// A file of the library, open while its owner lives.
class ForeignHdf5 : public ::testing::Test {
 protected:
  ForeignHdf5() : file_(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)) {}
  ~ForeignHdf5() override { close(); }

  Hdf5File reopened() {
    close();
    return Hdf5File::open(path_);
  }
  void create_anew(hid_t creation, hid_t access) {
    close();
    file_ = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, creation, access);
  }
  void add_number(const char* name, double number) {
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute = H5Acreate2(file_, name, H5T_IEEE_F64BE, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_DOUBLE, &number);
    H5Aclose(attribute);
    H5Sclose(space);
  }
  void close() {
    if (file_ >= 0) H5Fclose(file_);
    file_ = H5I_INVALID_HID;
  }
  /// 6 x 4 x 5 numbers from 0 on in chunks of that shape.
  void add_chunked(const std::array<hsize_t, 3>& chunk, bool shuffle, bool deflate,
                   hid_t type = H5T_NATIVE_UINT16, void (*more)(hid_t) = nullptr) {
    const std::array<hsize_t, 3> shape{6, 4, 5};
    const hid_t space = H5Screate_simple(3, shape.data(), nullptr);
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(properties, 3, chunk.data());
    if (shuffle) H5Pset_shuffle(properties);
    if (deflate) H5Pset_deflate(properties, 4);
    if (more != nullptr) more(properties);
    const hid_t set = H5Dcreate2(file_, "depth", type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    std::vector<double> values(120);
    std::iota(values.begin(), values.end(), 0.0);
    H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(set);
    H5Pclose(properties);
    H5Sclose(space);
  }
  void add_texts(const char* name, std::size_t length, hsize_t count) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, length);
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t attribute = H5Acreate2(file_, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    if (length == H5T_VARIABLE) {
      const std::string text(500, 'x');
      const std::vector<const char*> texts(count, text.c_str());
      H5Awrite(attribute, type, texts.data());
    } else {
      H5Awrite(attribute, type, std::string(length * count, 'x').data());
    }
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
  }
  std::string fault_of_depth() {
    const Hdf5File file = reopened();
    return error_of([&] { file.read<float>("depth"); });
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "foreign.h5";
  hid_t file_;
};

/// The settings with which a newer file is made.
hid_t newer_format(H5F_libver_t format) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_libver_bounds(access, format, H5F_LIBVER_LATEST);
  return access;
}

TEST_F(ForeignHdf5, TextsOfManyElementsAreRefused) {
  add_texts("variable", H5T_VARIABLE, 500);
  add_texts("fixed", 500, 500 / 8);
  const Hdf5File file = reopened();
  EXPECT_THAT(error_of([&] { file.text_attribute("variable"); }), HasSubstr("a text of variable length"));
  EXPECT_THAT(error_of([&] { file.text_attribute("fixed"); }), HasSubstr("has 62 values, expected 1"));
}

TEST_F(ForeignHdf5, ATextOfVariableLengthIsRefusedWithTheWordsThatHelp) {
  add_texts("format", H5T_VARIABLE, 1);
  const Hdf5File file = reopened();
  EXPECT_THAT(error_of([&] { file.text_attribute("format"); }), HasSubstr("as Knuckle 0.1 wrote it"));
}

TEST_F(ForeignHdf5, ChunksOfAnyShapeAreReadAsTheLibraryDoes) {
  for (const std::array<hsize_t, 3>& chunk :
       {std::array<hsize_t, 3>{1, 4, 5}, {2, 3, 2}, {4, 4, 5}, {6, 1, 3}}) {
    for (const bool shuffle : {false, true}) {
      for (const bool deflate : {false, true}) {
        close();
        file_ = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
        add_chunked(chunk, shuffle, deflate);
        const Hdf5File file = reopened();
        const auto all = file.read<std::uint16_t>("depth");
        for (std::size_t i = 0; i < 120; ++i) ASSERT_EQ(all.values[i], i);
        std::vector<double> rows(40);
        file.read_rows("depth", 3, 2, rows.data());
        for (std::size_t i = 0; i < 40; ++i) ASSERT_EQ(rows[i], 60.0 + static_cast<double>(i));
      }
    }
  }
}

TEST_F(ForeignHdf5, NumbersOfAnotherTypeOrOrderAreConverted) {
  add_chunked({2, 4, 5}, true, true, H5T_STD_I32BE);
  const Hdf5File file = reopened();
  EXPECT_EQ(file.read<std::uint8_t>("depth").values[119], 119);
}

TEST_F(ForeignHdf5, OtherFiltersAreRefused) {
  add_chunked({2, 4, 5}, false, false, H5T_NATIVE_UINT16,
              [](hid_t properties) { H5Pset_fletcher32(properties); });
  EXPECT_THAT(fault_of_depth(), HasSubstr("expected shuffle and deflate alone"));
}

TEST_F(ForeignHdf5, LinksAreRefused) {
  add_chunked({2, 4, 5}, false, false);
  H5Lmove(file_, "depth", file_, "real", H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_external("other.h5", "/depth", file_, "depth", H5P_DEFAULT, H5P_DEFAULT);
  EXPECT_THAT(fault_of_depth(), HasSubstr("is a link"));
  file_ = H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  H5Ldelete(file_, "depth", H5P_DEFAULT);
  H5Lcreate_soft("/real", file_, "depth", H5P_DEFAULT, H5P_DEFAULT);
  EXPECT_THAT(fault_of_depth(), HasSubstr("is a link"));
  EXPECT_EQ(Hdf5File::open(path_).read<float>("real").values[7], 7.0F);
}

TEST_F(ForeignHdf5, ALinkByNameStaysOneWhateverItsAddressSays) {
  add_chunked({2, 4, 5}, false, false);
  H5Lmove(file_, "depth", file_, "real", H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_soft("/real", file_, "depth", H5P_DEFAULT, H5P_DEFAULT);
  close();
  // Its entry: no address, and the kind 2. The library writes none there; others may.
  std::string bytes = read_text_file(path_);
  const std::size_t entry = bytes.find(std::string(8, '\xff') + std::string("\2\0\0\0", 4));
  ASSERT_NE(entry, std::string::npos);
  bytes.replace(entry, 8, std::string("\x60\0\0\0\0\0\0\0", 8));  // the group itself
  write_text_file(path_, bytes);
  EXPECT_THAT(fault_of_depth(), HasSubstr("is a link"));
}

TEST_F(ForeignHdf5, ExternalStorageIsRefused) {
  const std::array<hsize_t, 1> shape{16};
  const hid_t space = H5Screate_simple(1, shape.data(), nullptr);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_external(properties, "/etc/passwd", 0, H5F_UNLIMITED);
  H5Dclose(H5Dcreate2(file_, "depth", H5T_NATIVE_UINT8, space, H5P_DEFAULT, properties, H5P_DEFAULT));
  H5Pclose(properties);
  H5Sclose(space);
  EXPECT_THAT(fault_of_depth(), HasSubstr("is stored in another file"));
}

TEST_F(ForeignHdf5, AChunkLargerThanItMayBeIsRefused) {
  const std::array<hsize_t, 1> shape{hsize_t{1} << 31};
  const hid_t space = H5Screate_simple(1, shape.data(), nullptr);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(properties, 1, shape.data());
  H5Pset_deflate(properties, 9);
  H5Dclose(H5Dcreate2(file_, "depth", H5T_NATIVE_UINT8, space, H5P_DEFAULT, properties, H5P_DEFAULT));
  H5Pclose(properties);
  H5Sclose(space);
  EXPECT_THAT(fault_of_depth(), HasSubstr("in chunks of 2147483648 bytes"));
}

TEST_F(ForeignHdf5, TheFormatOfVersion18IsRead) {
  create_anew(H5P_DEFAULT, newer_format(H5F_LIBVER_V18));
  add_chunked({4, 3, 2}, true, true);
  add_number("number", 2.5);
  const Hdf5File file = reopened();
  EXPECT_EQ(file.number_attribute("number"), 2.5);
  const auto depth = file.read<std::int64_t>("depth");
  EXPECT_THAT(depth.shape, ElementsAre(6, 4, 5));
  for (std::int64_t i = 0; i < 120; ++i) ASSERT_EQ(depth.values[static_cast<std::size_t>(i)], i);
}

TEST_F(ForeignHdf5, OfVersion18WithAnUnknownHeaderOrLinkIsRefused) {
  create_anew(H5P_DEFAULT, newer_format(H5F_LIBVER_V18));
  add_chunked({4, 3, 2}, true, true);
  close();
  const std::string whole = read_text_file(path_);
  const auto fault_with = [&](std::size_t place, char number) {
    std::string bytes = whole;
    bytes.at(place) = number;
    write_text_file(path_, bytes);
    return error_of([&] { Hdf5File::open(path_).read<int>("depth"); });
  };
  EXPECT_THAT(fault_with(whole.find("OHDR") + 4, 3),
              HasSubstr("foreign.h5: the HDF5 file is damaged: an object's header is of an unknown version"));
  // A link has its version, flags, the length of its name, and this.
  const std::string link("\1\0\5depth", 8);
  const std::size_t without_order = whole.find(link);
  ASSERT_NE(without_order, std::string::npos);
  EXPECT_THAT(fault_with(without_order, 2), HasSubstr("a link is of an unknown version"));
}

TEST_F(ForeignHdf5, BytesBeforeTheFileAreSkipped) {
  const hid_t creation = H5Pcreate(H5P_FILE_CREATE);
  H5Pset_userblock(creation, 2048);
  create_anew(creation, H5P_DEFAULT);
  add_chunked({4, 3, 2}, true, true);
  EXPECT_EQ(reopened().read<std::uint16_t>("depth").values[119], 119);
}

TEST_F(ForeignHdf5, NewerLayoutsAreRefusedWithTheWordsThatHelp) {
  create_anew(H5P_DEFAULT, newer_format(H5F_LIBVER_LATEST));
  add_chunked({2, 4, 5}, false, true);
  EXPECT_THAT(fault_of_depth(), AllOf(HasSubstr("'depth' in a layout of version 4, which is not read"),
                                      HasSubstr("libver='earliest'")));
  create_anew(H5P_DEFAULT, newer_format(H5F_LIBVER_V18));
  for (int i = 0; i < 20; ++i) add_number(std::to_string(i).c_str(), i);
  EXPECT_THAT(error_of([&] { reopened(); }), HasSubstr("has attributes outside of a header"));
  create_anew(H5P_DEFAULT, newer_format(H5F_LIBVER_V18));
  for (int i = 0; i < 20; ++i)
    H5Gclose(H5Gcreate2(file_, std::to_string(i).c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  EXPECT_THAT(error_of([&] { reopened(); }), HasSubstr("has a group of many links"));
}

TEST_F(ForeignHdf5, HundredsOfArraysAndAttributesAreFound) {
  for (int i = 0; i < 300; ++i) {
    const hsize_t two = 2;
    const std::string name = fmt::format("array number {}", i);
    const hid_t space = H5Screate_simple(1, &two, nullptr);
    const hid_t set =
        H5Dcreate2(file_, name.c_str(), H5T_STD_I16BE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const std::array<int, 2> values{i, -i};
    H5Dwrite(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(set);
    H5Sclose(space);
    add_number(name.c_str(), 0.5 * i);
  }
  const Hdf5File file = reopened();
  for (int i = 0; i < 300; ++i) {
    const std::string name = fmt::format("array number {}", i);
    EXPECT_THAT(file.read<int>(name).values, ElementsAre(i, -i));
    EXPECT_EQ(file.number_attribute(name), 0.5 * i);
  }
}

TEST_F(ForeignHdf5, WhatWasNeverWrittenHasTheFillValue) {
  for (const bool is_chunked : {false, true}) {
    for (const H5D_layout_t layout : {H5D_CONTIGUOUS, H5D_CHUNKED}) {
      create_anew(H5P_DEFAULT, is_chunked ? newer_format(H5F_LIBVER_V18) : H5P_DEFAULT);
      const std::array<hsize_t, 2> shape{3, 4};
      const hid_t space = H5Screate_simple(2, shape.data(), nullptr);
      const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
      if (layout == H5D_CHUNKED) H5Pset_chunk(properties, 2, std::array<hsize_t, 2>{2, 3}.data());
      const int value = -7;
      H5Pset_fill_value(properties, H5T_NATIVE_INT, &value);
      H5Dclose(H5Dcreate2(file_, "depth", H5T_STD_I16LE, space, H5P_DEFAULT, properties, H5P_DEFAULT));
      H5Pclose(properties);
      H5Sclose(space);
      const auto depth = reopened().read<int>("depth");
      EXPECT_THAT(depth.shape, ElementsAre(3, 4));
      EXPECT_THAT(depth.values, AllOf(SizeIs(12), Each(-7)));
    }
  }
}

TEST_F(ForeignHdf5, ValuesInTheHeaderAreRead) {
  const std::array<hsize_t, 2> shape{3, 2};
  const hid_t space = H5Screate_simple(2, shape.data(), nullptr);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_layout(properties, H5D_COMPACT);
  const hid_t set = H5Dcreate2(file_, "depth", H5T_IEEE_F32BE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  const std::array<float, 6> values{1.5F, -2, 3, 4, 5e20F, 6};
  H5Dwrite(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Dclose(set);
  H5Pclose(properties);
  H5Sclose(space);
  EXPECT_THAT(reopened().read<float>("depth").values, ElementsAreArray(values));
}

TEST_F(ForeignHdf5, ChunksThatWereLeftOutOfFiltersAreRead) {
  const std::array<hsize_t, 1> shape{4};
  const hid_t space = H5Screate_simple(1, shape.data(), nullptr);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(properties, 1, shape.data());
  H5Pset_shuffle(properties);
  H5Pset_deflate(properties, 4);
  const hid_t set = H5Dcreate2(file_, "depth", H5T_STD_U16LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  const std::array<std::uint16_t, 4> values{1, 258, 3, 65535};
  const hsize_t place = 0;
  constexpr std::uint32_t kNeither = 3;
  H5Dwrite_chunk(set, H5P_DEFAULT, kNeither, &place, sizeof(values), values.data());
  H5Dclose(set);
  H5Pclose(properties);
  H5Sclose(space);
  EXPECT_THAT(reopened().read<std::uint16_t>("depth").values, ElementsAreArray(values));
}

TEST_F(ForeignHdf5, AnArrayThatShrankIsReadAsItIs) {
  const std::array<hsize_t, 1> shape{10};
  const hsize_t unlimited = H5S_UNLIMITED;
  const hid_t space = H5Screate_simple(1, shape.data(), &unlimited);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(properties, 1, std::array<hsize_t, 1>{3}.data());
  const hid_t set = H5Dcreate2(file_, "depth", H5T_NATIVE_INT, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  std::array<int, 10> values{};
  std::iota(values.begin(), values.end(), 1);
  H5Dwrite(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Dset_extent(set, std::array<hsize_t, 1>{4}.data());
  H5Dclose(set);
  H5Pclose(properties);
  H5Sclose(space);
  EXPECT_THAT(reopened().read<int>("depth").values, ElementsAre(1, 2, 3, 4));
}

TEST_F(ForeignHdf5, ChunksBesideTheArrayDoNotCount) {
  add_chunked({2, 3, 2}, false, false);
  close();
  std::string bytes = read_text_file(path_);
  const std::array<std::uint64_t, 3> shape{6, 4, 5};
  const std::string extent(reinterpret_cast<const char*>(shape.data()), sizeof(shape));
  const std::size_t place = bytes.find(extent);
  ASSERT_NE(place, std::string::npos);
  bytes[place + 8] = 3;  // of 4 columns: the chunks from the fourth on lie beside the array now
  write_text_file(path_, bytes);
  const auto depth = Hdf5File::open(path_).read<int>("depth");
  ASSERT_THAT(depth.shape, ElementsAre(6, 3, 5));
  for (int row = 0; row < 6; ++row) {
    for (int i = 0; i < 15; ++i)
      ASSERT_EQ(depth.values[static_cast<std::size_t>(15 * row + i)], 20 * row + i);
  }
}

TEST_F(ForeignHdf5, NumbersThatDoNotFitAreRefused) {
  add_chunked({2, 4, 5}, true, true, H5T_IEEE_F32LE);
  EXPECT_EQ(reopened().read<std::uint8_t>("depth").values[119], 119);
  create_anew(H5P_DEFAULT, H5P_DEFAULT);
  const hsize_t one = 1;
  const hid_t space = H5Screate_simple(1, &one, nullptr);
  const hid_t set = H5Dcreate2(file_, "depth", H5T_STD_I32LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const int value = 70000;
  H5Dwrite(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value);
  H5Dclose(set);
  H5Sclose(space);
  const Hdf5File file = reopened();
  EXPECT_EQ(file.read<float>("depth").values[0], 70000.0F);
  EXPECT_THAT(error_of([&] { file.read<std::uint16_t>("depth"); }),
              HasSubstr("foreign.h5: depth: holds 70000, expected whole numbers from 0 to 65535"));
}

TEST_F(ForeignHdf5, AGroupInPlaceOfAnArrayIsRefused) {
  H5Gclose(H5Gcreate2(file_, "depth", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  EXPECT_THAT(fault_of_depth(), HasSubstr("expected an array"));
}

}  // namespace
}  // namespace knuckle
