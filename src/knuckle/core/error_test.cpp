// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/error.h"

#include <string>

#include "knuckle/core/testing.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

using testing::error_of;

TEST(Error, IsOneLineThatATerminalShowsAsItIs) {
  const std::string name = "a\nb\x1b[2J\xff\xe2\x80\xae.png";
  EXPECT_EQ(error_of([&] { fail("{}: is no image", name); }), "a\\nb\\x1b[2J\\xff\\u{202e}.png: is no image");
  EXPECT_STREQ(Error(name).what(), printable(name).c_str());
}

TEST(Error, SaysWhatIsPrintableAsItWasTold) {
  EXPECT_STREQ(Error("3 \xe2\x82\xac").what(), "3 \xe2\x82\xac");
}

TEST(Error, EndsSomewhereHoweverLongWhatItQuotes) {
  EXPECT_EQ(error_of([] { fail("{}", std::string(16000, 'x')); }), std::string(16000, 'x'));
  EXPECT_EQ(error_of([] { fail("a.png: {}, expected b", std::string(17000, 'x')); }),
            "a.png: " + std::string(7991, 'x') + "..." + std::string(7986, 'x') + ", expected b")
      << "which file, and what was expected, lie at the ends";
  EXPECT_LE(error_of([] { fail("{}", std::string(16000, '\x01')); }).size(), 16000u);
  for (const std::string start : {"", "a", "ab"}) {
    std::string euros = start;
    while (euros.size() < 20000) euros += "\xe2\x82\xac";
    const std::string shown = error_of([&] { fail("{}", euros); });
    EXPECT_GT(shown.size(), 15990u);
    EXPECT_EQ(printable(shown), shown) << "no part of a sign";
  }
}

}  // namespace
}  // namespace knuckle
