// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/image.h"

#include <numeric>

#include <gtest/gtest.h>

#include "knuckle/core/box.h"

namespace knuckle {
namespace {

Image<int> counted_image(int width, int height) {
  Image<int> image(width, height);
  std::iota(image.pixels().begin(), image.pixels().end(), 0);
  return image;
}

TEST(ImageTest, IsRowMajor) {
  const Image<int> image = counted_image(5, 3);
  EXPECT_EQ(image(0, 0), 0);
  EXPECT_EQ(image(4, 0), 4);
  EXPECT_EQ(image(0, 1), 5);
  EXPECT_EQ(image(4, 2), 14);
  EXPECT_EQ(image.row(1)[2], image(2, 1));
}

TEST(ImageTest, ContainsItsPixelsOnly) {
  const Image<int> image(5, 3);
  EXPECT_TRUE(image.contains(4, 2));
  EXPECT_FALSE(image.contains(5, 2));
  EXPECT_FALSE(image.contains(4, 3));
  EXPECT_FALSE(image.contains(-1, 0));
}

TEST(ImageTest, MirrorMovesColumnsAndIsItsOwnInverse) {
  const Image<int> image = counted_image(4, 2);
  const Image<int> mirror = mirrored(image);
  EXPECT_EQ(mirror(0, 1), image(3, 1));
  EXPECT_EQ(mirrored(mirror), image);
}

TEST(BoxTest, IntersectionHoldsThePixelsOfBoth) {
  const Box a{0, 0, 4, 4};
  const Box b{2, 1, 5, 2};
  const Box common = intersection(a, b);
  for (int row = -1; row < 6; ++row) {
    for (int column = -1; column < 8; ++column) {
      EXPECT_EQ(common.contains(column, row), a.contains(column, row) && b.contains(column, row));
    }
  }
}

TEST(BoxTest, BoxesApartHaveNothingInCommon) {
  EXPECT_EQ(intersection({0, 0, 2, 2}, {2, 0, 2, 2}), Box{});
  EXPECT_EQ(intersection({0, 0, 2, 2}, {5, 5, 2, 2}).area(), 0);
}

}  // namespace
}  // namespace knuckle
