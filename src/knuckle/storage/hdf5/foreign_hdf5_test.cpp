// SPDX-License-Identifier: Apache-2.0
// HDF5 files as others write them, some of them on purpose: made with the library itself.
#include <array>
#include <numeric>

#include <hdf5.h>

#include "knuckle/core/testing.h"
#include "knuckle/storage/hdf5/hdf5_file.h"

namespace knuckle {
namespace {

using ::testing::Each;
using testing::error_of;
using ::testing::HasSubstr;

/// A file of the library, open while its owner lives.
class ForeignHdf5 : public ::testing::Test {
 protected:
  ForeignHdf5() : file_(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)) {}
  ~ForeignHdf5() override { close(); }

  Hdf5File reopened() {
    close();
    return Hdf5File::open(path_);
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

TEST_F(ForeignHdf5, AGroupInPlaceOfAnArrayIsRefused) {
  H5Gclose(H5Gcreate2(file_, "depth", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  EXPECT_THAT(fault_of_depth(), HasSubstr("expected an array"));
}

}  // namespace
}  // namespace knuckle
