// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/label_server.h"

#include <chrono>
#include <cstring>
#include <fstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"
#include "knuckle/view/view_testing.h"

namespace knuckle {
namespace {

using nlohmann::json;
using testing::HttpAnswer;
using testing::PlainClient;
using testing::request;

constexpr int kLabelFrames = 3;

/// The JSON header of an image message; its pixels have to follow to the last.
json image_header(const std::string& message) {
  std::uint32_t size = 0;
  std::memcpy(&size, message.data(), sizeof(size));
  const json header = json::parse(message.substr(4, size));
  const auto pixels = header.at("width").get<std::size_t>() * header.at("height").get<std::size_t>();
  EXPECT_EQ(message.size(), 4 + size + 2 * pixels);
  return header;
}

class LabelServerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_web_server()) GTEST_SKIP() << "built without Boost";
    std::ofstream(folder_ / "index.html") << "live";
    std::ofstream(folder_ / "annotate.html") << "annotate";
    LabelSessionOptions options;
    options.author = "ann";
    options.estimate = [this](const Frame& frame) {
      return std::vector<EstimatedHand>{
          {HandSide::right, testing::pose_of_points(source_.truth(std::stoi(frame.name)))}};
    };
    session_.emplace(source_, journal_, options);
    server_.emplace(LabelInfo{.version = "1",
                              .source = "closing:hand",
                              .file = "labels.jsonl",
                              .author = "ann",
                              .estimator = {}},
                    *session_, WebServerOptions{.page = folder_.path(), .index = "annotate.html"});
    const std::string& address = server_->address();
    port_ = std::stoi(address.substr(address.rfind(':') + 1));
  }

  HttpAnswer get(std::string_view target, std::string_view more_fields = "") const {
    PlainClient one(port_);
    one.send(request(fmt::format("GET {}", target), more_fields));
    return one.answer();
  }
  HttpAnswer post(std::string_view body, std::string_view more_fields = "") const {
    PlainClient one(port_);
    one.send(request("POST /api/labels", more_fields, body));
    return one.answer();
  }
  static std::string verify(int frame, int revision) {
    return fmt::format(R"({{"act":"verify","frame":{},"side":"right","revision":{}}})", frame, revision);
  }

  testing::TemporaryFolder folder_;
  testing::ClosingHand source_{kLabelFrames};
  LabelJournal journal_{folder_ / "labels.jsonl", testing::closing_hand_head(kLabelFrames)};
  std::optional<LabelSession> session_;
  std::optional<LabelServer> server_;
  int port_ = 0;
};

TEST_F(LabelServerTest, ServesThePageForLabellingAndWhatItAsksFor) {
  EXPECT_EQ(get("/").body, "annotate");
  const json info = json::parse(get("/api/info").body);
  EXPECT_EQ(info.at("frames"), kLabelFrames);
  EXPECT_EQ(info.at("landmarks").size(), 22U);
  const json header = image_header(get("/api/frame?index=1").body);
  EXPECT_EQ(header.at("record").at("frame"), 1);
  EXPECT_EQ(header.at("record").at("hands").size(), 1U);
  EXPECT_EQ(header.at("labels")[0].at("landmarks").at("index_tip").at("state"), "estimated");
  EXPECT_GT(header.at("surface")[0].size(), 10U);
  EXPECT_LE(image_header(get("/api/thumbnail?index=2").body).at("width"), 96);
  EXPECT_EQ(get("/api/thumbnail?index=2").fields.at("content-type"), "application/octet-stream");
}

TEST_F(LabelServerTest, AChangeIsAnsweredAndOnTheDisk) {
  get("/api/frame?index=1");
  const HttpAnswer answer = post(
      R"({"act":"place","frame":1,"side":"right","revision":1,"landmark":"index_tip","pixel":[70,30],"seconds":1.5})");
  ASSERT_EQ(answer.status, 200) << answer.body;
  const json said = json::parse(answer.body);
  EXPECT_EQ(said.at("labels")[0].at("revision"), 2);
  EXPECT_EQ(said.at("labels")[0].at("landmarks").at("index_tip").at("state"), "corrected");
  EXPECT_EQ(said.at("fault"), "");
  EXPECT_EQ(read_label_file(folder_ / "labels.jsonl").find({1})->revision(), 2);
  EXPECT_EQ(json::parse(post(R"({"act":"undo"})").body).at("labels")[0].at("revision"), 3);
  EXPECT_EQ(json::parse(get("/api/standings").body).at("states").get<std::string>()[1], 'e');
}

TEST_F(LabelServerTest, TheSecondPageOnAFrameIsToldAndRefused) {
  get("/api/frame?index=0");
  PlainClient listener(port_);
  ASSERT_EQ(listener.open_socket("/api/changes").status, 101);
  EXPECT_EQ(post(verify(0, 1)).status, 200);
  // Estimates of other frames are told, too.
  json told = json::object();
  for (int i = 0; i < 10 && !(told.value("frame", -1) == 0 && told.value("revision", 0) == 2); ++i)
    told = json::parse(listener.message().bytes);
  EXPECT_EQ(told.at("revision"), 2);
  const HttpAnswer second = post(verify(0, 1));
  EXPECT_EQ(second.status, 409);
  EXPECT_TRUE(json::parse(second.body).at("refused"));
  EXPECT_EQ(json::parse(second.body).at("labels")[0].at("revision"), 2);
}

TEST_F(LabelServerTest, WhatIsMalformedTooLargeOrForeignIsRefused) {
  const auto refused = [&](const std::string& body, int status) {
    const HttpAnswer answer = post(body);
    EXPECT_EQ(answer.status, status) << body;
    EXPECT_EQ(std::ranges::count(answer.body, '\n'), 1) << "one line";
  };
  refused("{", 400);
  refused(verify(3, 1), 400);
  refused(verify(-1, 1), 400);
  refused(R"({"act":"place","frame":0,"side":"right","revision":0,"landmark":"nose","pixel":[1,1]})", 400);
  refused(std::string(8300, ' '), 413);
  for (const char* const target : {"/api/frame", "/api/frame?index=3", "/api/frame?index=-1",
                                   "/api/frame?index=1x", "/api/frame?index=99999999999999999999",
                                   "/api/next?after=3", "/api/next?after=-1", "/api/thumbnail?index="})
    EXPECT_EQ(get(target).status, 400) << target;
  EXPECT_EQ(get("/api/nothing").status, 404);
  EXPECT_EQ(get("/api/labels").status, 405);
  EXPECT_EQ(get("/api/info", "Host: example.org\r\n").status, 403);
  EXPECT_EQ(post(verify(0, 0), "Origin: http://example.org\r\n").status, 403);
  EXPECT_EQ(journal_.book().find({0}) == nullptr || journal_.book().find({0})->revision() == 1, true);
}

TEST_F(LabelServerTest, FramesAreEstimatedWhileNobodyAsks) {
  const auto all_are_estimated = [&] {
    return json::parse(get("/api/standings").body).at("states") == std::string(kLabelFrames, 'e');
  };
  for (int i = 0; i < 200 && !all_are_estimated(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_TRUE(all_are_estimated());
  EXPECT_TRUE(json::parse(get("/api/next?after=0").body).at("frame").is_number());
}

TEST_F(LabelServerTest, EndsWhileRequestsWait) {
  std::vector<PlainClient> clients;
  for (int i = 0; i < 20; ++i) {
    clients.emplace_back(port_);
    clients.back().send(request("GET /api/frame?index=1"));
  }
  server_.reset();
  for (PlainClient& one : clients) EXPECT_TRUE(one.ends());
}

}  // namespace
}  // namespace knuckle
