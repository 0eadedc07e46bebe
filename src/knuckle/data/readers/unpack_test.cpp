// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/unpack.h"

#include <span>
#include <string>

#include "knuckle/core/testing.h"
#include "knuckle/data/readers/recording_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::packed;

TEST(Unpack, GivesAsManyBytesAsItShouldOrNone) {
  const std::string content = "content of the chunk";
  const auto fault = [&](const std::string& bytes, Packing packing, std::uint64_t count) {
    const std::span packed(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    return error_of([&] { unpack(packed, packing, count, "here"); });
  };
  for (const auto& [name, packing] :
       {std::pair{"bz2", Packing::bz2}, {"lz4", Packing::lz4}, {"zstd", Packing::zstd}}) {
    SCOPED_TRACE(name);
    const std::string bytes = packed(content, name);
    const std::span whole(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    EXPECT_EQ(unpack(whole, packing, 20, "here").size(), 20u);
    EXPECT_THAT(fault(bytes, packing, 19), HasSubstr("here: unpacks to more than the 19 bytes it says"));
    EXPECT_THAT(fault(bytes, packing, 21), HasSubstr("here: unpacks to 20 bytes, expected 21"));
    EXPECT_THAT(fault(bytes + "!", packing, 20), HasSubstr("here: has 1 bytes after its packed ones"));
    EXPECT_THAT(fault(bytes.substr(0, bytes.size() - 1), packing, 20),
                HasSubstr("here: its packed bytes are cut short"));
    EXPECT_THAT(fault("no such bytes", packing, 20), HasSubstr("here: its packed bytes are damaged"));
  }
  EXPECT_THAT(fault(content, Packing::none, 19), HasSubstr("here: has 20 bytes, expected 19"));
}

}  // namespace
}  // namespace knuckle
