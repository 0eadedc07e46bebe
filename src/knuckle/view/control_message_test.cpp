// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/control_message.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;

TEST(ControlMessage, SaysOnOrOff) {
  EXPECT_TRUE(parse_recording_request(R"({"on": true})").on);
  EXPECT_FALSE(parse_recording_request(R"( {"on":false} )").on);
}

TEST(ControlMessage, AnythingElseIsRefused) {
  for (const std::string& text :
       {std::string(), std::string("{}"), std::string("[]"), std::string("true"), std::string(R"({"on": 1})"),
        std::string(R"({"on": "true"})"), std::string(R"({"on": true, "file": "/etc/passwd"})"),
        std::string(R"({"on": true)"), std::string(R"({"off": true})"), std::string("\xff\xfe{}"),
        std::string(200, '['), std::string(300, ' ') + R"({"on": true})"}) {
    EXPECT_THAT(error_of([&] { parse_recording_request(text); }), ::testing::HasSubstr("expected {\"on\""))
        << text;
  }
}

}  // namespace
}  // namespace knuckle
