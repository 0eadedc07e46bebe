// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_bytes.h"

#include "knuckle/core/testing.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

TEST(Hdf5Bytes, NoMoreAreReadThanThereAre) {
  const testing::TemporaryFolder folder;
  Hdf5Writer::create(folder / "a.h5").close();
  const Hdf5Bytes bytes(folder / "a.h5");
  EXPECT_EQ(bytes.read(bytes.size() - 4, 4).size(), 4u);
  for (const std::uint64_t count : {std::uint64_t{5}, std::uint64_t{1} << 60U, ~std::uint64_t{0}})
    EXPECT_THAT(error_of([&] { bytes.read(bytes.size() - 4, count); }), HasSubstr("lie beyond its end"));
  EXPECT_THAT(error_of([&] { bytes.read(bytes.size() + 1, 0); }), HasSubstr("lie beyond its end"));
}

}  // namespace
}  // namespace knuckle
