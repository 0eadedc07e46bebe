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
  EXPECT_EQ(error_of([] { fail("{}", std::string(16001, 'x')); }), std::string(16000, 'x') + "...");
  EXPECT_EQ(error_of([] { fail("{}", std::string(16000, '\x01')); }).size(), 16003u);
  const std::string euros = [] {
    std::string text;
    while (text.size() < 20000) text += "\xe2\x82\xac";
    return text;
  }();
  EXPECT_EQ(error_of([&] { fail("{}", euros); }), euros.substr(0, 15999) + "...") << "no part of a sign";
}

}  // namespace
}  // namespace knuckle
