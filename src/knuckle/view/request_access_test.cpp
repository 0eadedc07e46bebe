// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/request_access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace knuckle {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(RequestAccess, KnowsTheNamesOfThisMachine) {
  for (const char* const host :
       {"localhost", "LocalHost:8790", "127.0.0.1", "127.0.0.1:1", "127.1.2.3:65535", "[::1]", "[::1]:8790"})
    EXPECT_TRUE(is_local_host(host)) << host;
  for (const char* const host : {"",
                                 ":",
                                 ":8790",
                                 "localhost:",
                                 "localhost:x",
                                 "localhost:123456",
                                 "localhost.evil.org",
                                 "evil.org",
                                 "127.0.0.1.evil.org",
                                 "127.0.0",
                                 "127.0.0.0.1",
                                 "127..0.1",
                                 "128.0.0.1",
                                 "::1",
                                 "[::1",
                                 "[::2]",
                                 "localhost:1:2",
                                 "localhost ",
                                 "localhost/",
                                 "user@localhost",
                                 "127.0.0.1000",
                                 "0.0.0.0"})
    EXPECT_FALSE(is_local_host(host)) << host;
}

TEST(RequestAccess, TakesTargetsApart) {
  EXPECT_EQ(path_of("/api/info?token=1"), "/api/info");
  EXPECT_EQ(path_of("/a#b"), "/a");
  EXPECT_EQ(path_of(""), "");
  EXPECT_EQ(query_value("/?token=abc", "token"), "abc");
  EXPECT_EQ(query_value("/?a=1&token=abc&b=2", "token"), "abc");
  EXPECT_EQ(query_value("/?a=1&token=abc#x", "token"), "abc");
  EXPECT_EQ(query_value("/?mytoken=abc", "token"), "");
  EXPECT_EQ(query_value("/?token", "token"), "");
  EXPECT_EQ(query_value("/token=abc", "token"), "");
}

std::string refusal_here(std::string_view host, std::string_view origin = "") {
  return refusal_of({.target = "/", .host = host, .origin = origin, .cookie = ""}, {});
}

TEST(RequestAccess, WithoutATokenThisMachineAloneIsServed) {
  EXPECT_THAT(refusal_here("localhost:8790"), IsEmpty());
  EXPECT_THAT(refusal_here("localhost:8790", "http://localhost:8790"), IsEmpty());
  EXPECT_THAT(refusal_here("localhost:8790", "http://127.0.0.1:9000"), IsEmpty());
  EXPECT_THAT(refusal_here(""), HasSubstr("this machine alone"));
  EXPECT_THAT(refusal_here("evil.org"), HasSubstr("this machine alone")) << "DNS rebinding";
  EXPECT_THAT(refusal_here("192.168.0.7:8790"), HasSubstr("this machine alone"));
  for (const char* const origin : {"http://evil.org", "null", "https://localhost.evil.org", "file://", "x",
                                   "http://", "http://localhost/path", "chrome-extension://localhost"})
    EXPECT_THAT(refusal_here("localhost", origin), HasSubstr("other places")) << origin;
}

TEST(RequestAccess, ATokenIsWantedOfAll) {
  const RequestAccess access{.token = "00112233445566778899aabbccddeeff", .cookie_name = "kt"};
  const auto refusal = [&](std::string_view target, std::string_view cookie = "",
                           std::string_view origin = "") {
    return refusal_of({.target = target, .host = "lab:8790", .origin = origin, .cookie = cookie}, access);
  };
  EXPECT_THAT(refusal("/?token=00112233445566778899aabbccddeeff"), IsEmpty());
  EXPECT_THAT(refusal("/?token=00112233445566778899aabbccddeeff", "", "http://any.org"), IsEmpty());
  for (const char* const target :
       {"/", "/?token=", "/?token=0", "/?token=00112233445566778899aabbccddeefe",
        "/?token=00112233445566778899aabbccddeeff0", "/?token=00112233445566778899AABBCCDDEEFF"})
    EXPECT_THAT(refusal(target), HasSubstr("token")) << target;
  EXPECT_THAT(refusal("/", "a=b; kt=00112233445566778899aabbccddeeff"), IsEmpty());
  EXPECT_THAT(refusal("/", "kt=00112233445566778899aabbccddeeff", "http://lab:8790"), IsEmpty());
  EXPECT_THAT(refusal("/", "kt=00112233445566778899aabbccddeeff", "http://lab:8080"),
              HasSubstr("other places"));
  EXPECT_THAT(refusal("/", "xkt=00112233445566778899aabbccddeeff"), HasSubstr("token"));
  EXPECT_THAT(refusal("/", "kt=0"), HasSubstr("token"));
  EXPECT_THAT(refusal("/", "kt2=0; kt=00112233445566778899aabbccddeeff"), IsEmpty()) << "of another server";
  EXPECT_THAT(refusal("/", "kt200112233445566778899aabbccddeeff"), HasSubstr("token"));
}

TEST(RequestAccess, TokensDiffer) {
  const std::string token = random_token();
  EXPECT_EQ(token.size(), 32U);
  EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(token, random_token());
}

}  // namespace
}  // namespace knuckle
