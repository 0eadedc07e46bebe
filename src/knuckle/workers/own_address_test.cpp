// SPDX-License-Identifier: Apache-2.0
#include "knuckle/workers/own_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace knuckle {
namespace {

TEST(OwnAddress, TowardsTheLoopbackIsTheLoopback) {
  EXPECT_EQ(own_address_towards("127.0.0.1", 29500), "127.0.0.1");
  EXPECT_EQ(own_address_towards("127.0.0.7", 29500), "127.0.0.1") << "the own end, not the other one";
  EXPECT_THAT(own_address_towards("localhost", 29500), ::testing::AnyOf("127.0.0.1", "::1"));
}

TEST(OwnAddress, TowardsNobodyIsNone) {
  EXPECT_EQ(own_address_towards("", 29500), std::nullopt);
}

}  // namespace
}  // namespace knuckle
