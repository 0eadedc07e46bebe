// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/live_server.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "knuckle/core/testing.h"
#include "knuckle/view/view_testing.h"

namespace knuckle {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
using ::testing::AnyOf;
using testing::client_frame;
using ::testing::Eq;
using testing::error_of;
using ::testing::HasSubstr;
using testing::HttpAnswer;
using testing::open_descriptors;
using testing::PlainClient;
using testing::request;
using testing::SocketMessage;

constexpr int kText = 1;
constexpr int kBinary = 2;

/// A frame of which all that is said is its number.
std::shared_ptr<const LiveUpdate> update_of(int number, int width = 64, int height = 48) {
  auto frame = std::make_shared<Frame>();
  frame->camera = {.width = width, .height = height, .fx = 50, .fy = 50, .cx = 32, .cy = 24};
  frame->depth_mm = Image<float>(width, height, static_cast<float>(number + 1));
  auto update = std::make_shared<LiveUpdate>();
  update->frame = std::move(frame);
  update->record.frame = number;
  update->record.name = std::to_string(number);
  return update;
}

int number_in(const std::string& record) {
  return json::parse(record).at("frame").get<int>();
}

json header_of(const std::string& message) {
  std::uint32_t size = 0;
  std::memcpy(&size, message.data(), sizeof(size));
  return json::parse(message.substr(4, size));
}

class LiveServerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_live_server()) GTEST_SKIP() << "built without Boost";
    std::ofstream(folder_ / "index.html") << "<!doctype html><title>page</title>";
    std::ofstream(folder_ / "app.js") << "let x = 1;";
    options_.page = folder_.path();
    options_.port = 0;
  }

  void start(RecordingControl recording = {}) {
    const LiveInfo info{.version = "1",
                        .source = "test",
                        .pipeline = "p.toml",
                        .convention = superset_convention(),
                        .can_record = static_cast<bool>(recording.set)};
    server_ = std::make_unique<LiveServer>(info, options_, std::move(recording));
    const std::string address = server_->address();
    port_ = std::stoi(address.substr(address.rfind(':') + 1));
  }

  PlainClient client() const { return PlainClient(port_); }
  HttpAnswer get(std::string_view target, std::string_view more_fields = "") const {
    PlainClient one = client();
    one.send(request(fmt::format("GET {}", target), more_fields));
    return one.answer();
  }
  HttpAnswer post(std::string_view body, std::string_view more_fields = "") const {
    PlainClient one = client();
    one.send(request("POST /api/recording", more_fields, body));
    return one.answer();
  }
  /// Clients are connected when they get what is published.
  PlainClient socket(std::string_view target) const {
    PlainClient one = client();
    EXPECT_EQ(one.open_socket(target).status, 101);
    return one;
  }
  /// Publishes frames one by one, when all clients have seen those before.
  void publish_seen(std::vector<PlainClient>& clients, int count) {
    for (int number = 0; number < count; ++number) {
      server_->publish(update_of(number));
      for (PlainClient& one : clients) {
        const SocketMessage message = one.message();
        ASSERT_EQ(message.kind, kText);
        ASSERT_EQ(number_in(message.bytes), number);
      }
    }
  }
  bool is_alive() const { return get("/api/info").status == 200; }

  testing::TemporaryFolder folder_;
  LiveServerOptions options_;
  std::unique_ptr<LiveServer> server_;
  int port_ = 0;
};

TEST_F(LiveServerTest, ServesThePage) {
  start();
  const HttpAnswer page = get("/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<!doctype html><title>page</title>");
  EXPECT_EQ(page.fields.at("content-type"), "text/html; charset=utf-8");
  EXPECT_EQ(page.fields.at("x-content-type-options"), "nosniff");
  EXPECT_EQ(page.fields.at("cache-control"), "no-cache");
  EXPECT_THAT(page.fields.at("content-security-policy"), HasSubstr("default-src 'self'"));
  EXPECT_FALSE(page.fields.contains("set-cookie"));
  EXPECT_EQ(get("/index.html?x=1").body, page.body);
  EXPECT_EQ(get("/app.js").fields.at("content-type"), "text/javascript; charset=utf-8");
  for (const char* const target : {"/none.js", "/../app.js", "/./app.js", "//app.js", "/%61pp.js", "/app.js/",
                                   "/etc/passwd", "/..%2f..%2fetc/passwd", "app.js", "*", "/APP.JS"})
    EXPECT_EQ(get(target).status, 404) << target;
}

TEST_F(LiveServerTest, SaysWhereThereIsNoPage) {
  options_.page = folder_ / "none";
  start();
  EXPECT_EQ(get("/").status, 404);
  EXPECT_THAT(get("/").body, HasSubstr("The page is not installed"));
  EXPECT_TRUE(is_alive());
}

TEST_F(LiveServerTest, HeadHasTheLengthAndNoBody) {
  start();
  PlainClient one = client();
  one.send(request("HEAD /app.js") + request("GET /app.js"));
  EXPECT_EQ(one.answer(false).fields.at("content-length"), "10");
  EXPECT_EQ(one.answer().body, "let x = 1;") << "the next answer follows at once";
}

TEST_F(LiveServerTest, InfoSaysWhatIsServed) {
  start();
  const HttpAnswer before = get("/api/info");
  EXPECT_EQ(before.status, 200);
  EXPECT_EQ(before.fields.at("content-type"), "application/json");
  EXPECT_TRUE(json::parse(before.body)["camera"].is_null());
  std::vector<PlainClient> clients;
  clients.push_back(socket("/api/records"));
  publish_seen(clients, 1);
  EXPECT_EQ(json::parse(get("/api/info").body)["camera"]["width"], 64);
}

TEST_F(LiveServerTest, OtherMethodsAreRefused) {
  start();
  for (const char* const method : {"POST /", "PUT /app.js", "DELETE /api/info", "OPTIONS /", "TRACE /"}) {
    PlainClient one = client();
    one.send(request(method));
    const HttpAnswer answer = one.answer();
    EXPECT_EQ(answer.status, 405) << method;
    EXPECT_EQ(answer.fields.at("allow"), "GET, HEAD");
  }
  EXPECT_EQ(get("/api/recording").status, 405);
  EXPECT_EQ(get("/api/records").status, 426);
  EXPECT_EQ(get("/api/frames").status, 426);
}

TEST_F(LiveServerTest, ForeignHostsAndOriginsAreRefused) {
  start();
  const std::string local = fmt::format("Host: localhost:{}\r\n", port_);
  EXPECT_EQ(get("/api/info", local).status, 200);
  EXPECT_EQ(get("/api/info", local + fmt::format("Origin: http://localhost:{}\r\n", port_)).status, 200);
  EXPECT_EQ(get("/api/info", local + "Origin: http://evil.org\r\n").status, 403);
  EXPECT_EQ(get("/api/info", local + "Origin: null\r\n").status, 403);
  EXPECT_EQ(get("/api/info", "Host: evil.org\r\n").status, 403);
  EXPECT_EQ(get("/", fmt::format("Host: evil.org:{}\r\n", port_)).status, 403);
  EXPECT_EQ(get("/", "Host: localhost\r\nHost: evil.org\r\n").status, 400);
  EXPECT_EQ(get("/", "Host:\r\n").status, 403);
  for (const char* const target : {"/api/records", "/api/frames"}) {
    EXPECT_EQ(client().open_socket(target, "Origin: http://evil.org\r\n").status, 403);
    EXPECT_EQ(client().open_socket(target, "Origin: http://localhost\r\n").status, 101);
  }
  PlainClient old = client();
  old.send("GET /api/info HTTP/1.0\r\n\r\n");
  EXPECT_EQ(old.answer().status, 403) << "no Host";
}

TEST_F(LiveServerTest, AnotherHostNeedsItsToken) {
  options_.host = "0.0.0.0";
  start();
  const std::string address = server_->address();
  const std::string token = address.substr(address.find("?token=") + 7);
  ASSERT_EQ(token.size(), 32U);
  const std::string with_token = "?token=" + token;
  for (const char* const target : {"/", "/app.js", "/api/info", "/api/records.jsonl"}) {
    EXPECT_EQ(get(target).status, 403) << target;
    EXPECT_EQ(get(target, "Host: lab.example\r\n").status, 403) << target;
    EXPECT_EQ(get(target + with_token, "Host: lab.example\r\n").status, 200) << target;
    EXPECT_EQ(get(target + with_token + "0").status, 403) << target;
  }
  EXPECT_EQ(post(R"({"on": true})").status, 403);
  EXPECT_EQ(client().open_socket("/api/records").status, 403);
  EXPECT_EQ(client().open_socket("/api/records" + with_token).status, 101);
  const std::string cookie = get("/" + with_token).fields.at("set-cookie");
  EXPECT_THAT(cookie, HasSubstr("HttpOnly; SameSite=Strict"));
  const std::string sent = "Host: lab.example\r\nCookie: " + cookie.substr(0, cookie.find(';')) + "\r\n";
  EXPECT_EQ(get("/app.js", sent).status, 200) << "what the page loads";
  EXPECT_EQ(get("/app.js", sent + "Origin: http://lab.example\r\n").status, 200);
  EXPECT_EQ(get("/app.js", sent + "Origin: http://evil.org\r\n").status, 403);
}

TEST_F(LiveServerTest, RecordsComeOneAMessage) {
  start();
  std::vector<PlainClient> clients;
  for (int i = 0; i < 3; ++i) clients.push_back(socket("/api/records"));
  publish_seen(clients, 20);
}

TEST_F(LiveServerTest, RecordsComeOneALine) {
  start();
  PlainClient chunked = client();
  chunked.send(request("GET /api/records.jsonl"));
  const HttpAnswer answer = chunked.answer();
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.fields.at("content-type"), "application/x-ndjson");
  EXPECT_EQ(answer.fields.at("transfer-encoding"), "chunked");
  PlainClient plain = client();
  plain.send("GET /api/records.jsonl HTTP/1.0\r\nHost: localhost\r\n\r\n");
  EXPECT_FALSE(plain.answer().fields.contains("transfer-encoding"));
  for (int number = 0; number < 5; ++number) {
    server_->publish(update_of(number));
    const std::string size = chunked.line();
    EXPECT_EQ(number_in(chunked.bytes(std::stoul(size, nullptr, 16))), number);
    EXPECT_EQ(chunked.line(), "");
    EXPECT_EQ(number_in(plain.line()), number);
  }
  server_.reset();
  EXPECT_EQ(chunked.line(), "0") << "the last chunk";
  EXPECT_TRUE(chunked.ends());
  EXPECT_TRUE(plain.ends());
}

TEST_F(LiveServerTest, FramesAreBinaryAndTheNewestComesAtOnce) {
  start();
  PlainClient early = socket("/api/frames");
  server_->publish(update_of(7));
  const SocketMessage message = early.message();
  ASSERT_EQ(message.kind, kBinary);
  EXPECT_EQ(header_of(message.bytes)["record"]["frame"], 7);
  EXPECT_EQ(message.bytes.size() % 4, 0U);
  PlainClient late = socket("/api/frames");
  EXPECT_EQ(late.message().bytes, message.bytes);
}

TEST_F(LiveServerTest, WhoReadsNothingDelaysNobody) {
  start();
  const PlainClient idle_records(port_, 4096);
  PlainClient asleep(port_, 4096);
  EXPECT_EQ(asleep.open_socket("/api/frames").status, 101);
  std::vector<PlainClient> clients;
  for (int i = 0; i < 3; ++i) clients.push_back(socket("/api/records"));
  PlainClient watcher = socket("/api/frames");
  for (int number = 0; number < 60; ++number) {
    server_->publish(update_of(number, 640, 480));  // 36 MB in all: more than the system keeps
    for (PlainClient& one : clients) ASSERT_EQ(number_in(one.message().bytes), number);
    ASSERT_EQ(header_of(watcher.message().bytes)["record"]["frame"], number);
  }
  // Who wakes up sees some old frames, which the system kept, and then the newest.
  int last = -1;
  int seen = 0;
  while (last < 59) {
    const SocketMessage message = asleep.message();
    ASSERT_EQ(message.kind, kBinary);
    const int number = header_of(message.bytes)["record"]["frame"];
    EXPECT_GT(number, last);
    last = number;
    ++seen;
  }
  EXPECT_LT(seen, 30) << "frames were queued for a client that does not read";
}

TEST_F(LiveServerTest, WhoTakesNothingIsLetGo) {
  options_.write_s = 0.2;
  start();
  PlainClient asleep(port_, 4096);
  EXPECT_EQ(asleep.open_socket("/api/frames").status, 101);
  for (int number = 0; number < 30; ++number) {
    server_->publish(update_of(number, 640, 480));
    std::this_thread::sleep_for(milliseconds(20));
  }
  EXPECT_TRUE(asleep.ends());
  EXPECT_TRUE(is_alive());
}

TEST_F(LiveServerTest, RequestsAreBounded) {
  start();
  const auto status_of = [&](const std::string& text) {
    PlainClient one = client();
    one.send(text);
    one.end_sending();
    return one.answer().status;
  };
  EXPECT_EQ(status_of(request("GET /", "X: " + std::string(20000, 'x') + "\r\n")), 431);
  EXPECT_THAT(status_of("GET /" + std::string(100000, 'x') + " HTTP/1.1\r\n\r\n"), AnyOf(431, 400));
  EXPECT_EQ(status_of(request("POST /api/recording", "", std::string(9000, ' '))), 413);
  EXPECT_EQ(status_of(request("POST /api/recording", "Content-Length: 99999999999999999999\r\n")), 400);
  EXPECT_EQ(status_of("\x16\x03\x01\x02" + std::string(100, '\0')), 400) << "TLS";
  EXPECT_EQ(status_of("HELLO\r\n\r\n"), 400);
  EXPECT_EQ(status_of("GET / HTTP/9.9\r\nHost: localhost\r\n\r\n"), 400);
  EXPECT_EQ(status_of(std::string("GET / HTTP/1.1\r\nHost: local\0host\r\n\r\n", 36)), 400);
  EXPECT_EQ(
      status_of(
          "GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\nContent-Length: 5\r\nHost: localhost\r\n\r\n"),
      400);
  EXPECT_THAT(status_of("\r\n\r\n\r\n"), AnyOf(400, 0));
  EXPECT_EQ(status_of(""), 0);
  EXPECT_TRUE(is_alive());
}

TEST_F(LiveServerTest, SlowRequestsEnd) {
  options_.request_s = 0.3;
  start();
  PlainClient silent = client();
  PlainClient slow = client();
  const std::string text = request("GET /api/info");
  const auto begin = std::chrono::steady_clock::now();
  for (const char c : text) {
    if (!slow.send(std::string(1, c))) break;
    std::this_thread::sleep_for(milliseconds(30));  // 1.3 s in all
  }
  EXPECT_EQ(slow.answer().status, 0);
  EXPECT_TRUE(silent.ends());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(8));
  EXPECT_TRUE(is_alive());
}

TEST_F(LiveServerTest, TenThousandBadRequestsAndAGoodOne) {
  start();
  const int before = open_descriptors();
  const std::string bad[] = {
      "HELLO\r\n\r\n",       request("GET /", "Host: evil.org\r\n"),  request("GET /none"),
      std::string(64, '\0'), request("POST /api/recording", "", "{"), "GET / HTTP/1.1\r\n"};
  for (int i = 0; i < 10000; ++i) {
    const PlainClient one = client();
    one.send(bad[static_cast<std::size_t>(i) % std::size(bad)]);
  }
  EXPECT_TRUE(is_alive());
  for (int i = 0; i < 500 && open_descriptors() > before; ++i) std::this_thread::sleep_for(milliseconds(10));
  EXPECT_EQ(open_descriptors(), before);
}

TEST_F(LiveServerTest, BadFramesOfASocketEndIt) {
  options_.request_s = 0.3;  // for what could still become a message
  start();
  const std::string huge = std::string("\x82\xff\x7f", 3) + std::string(7, '\xff') + std::string(4, '\0');
  const std::string longer_than_any =
      std::string("\x82\xff\xff", 3) + std::string(7, '\xff') + std::string(4, 'm');
  const std::string bad[] = {
      client_frame(0x81, "unmasked", false),
      huge,                                        // 2^63 - 1 bytes
      longer_than_any,                             // more than 2^63
      client_frame(0x01, "a part of a message"),   // fragmented
      client_frame(0x80, "a part of no message"),  // goes on with nothing
      client_frame(0x81, std::string(5000, 'x')),  // too long
      client_frame(0x83, "an unknown kind"),
      client_frame(0xF1, "reserved bits"),
      client_frame(0x89, std::string(200, 'x')),  // a ping that is too long
      client_frame(0x09, "a ping in parts"),
      client_frame(0x81, "\xff\xfe"),  // text that is no UTF-8
      client_frame(0x88, "\x01"),      // a farewell of half a code
      "GET / HTTP/1.1\r\n\r\n",
  };
  for (const char* const target : {"/api/records", "/api/frames"}) {
    for (const std::string& bytes : bad) {
      PlainClient one = socket(target);
      one.send(bytes);
      EXPECT_TRUE(one.ends()) << target << " " << ::testing::PrintToString(bytes.substr(0, 30));
    }
  }
  EXPECT_TRUE(is_alive());
}

TEST_F(LiveServerTest, WhatClientsSayIsNotLookedAt) {
  start();
  std::vector<PlainClient> clients;
  clients.push_back(socket("/api/records"));
  for (int i = 0; i < 100; ++i) clients[0].send(client_frame(0x81, std::string(4000, 'x')));
  clients[0].send(client_frame(0x82, ""));
  clients[0].send(client_frame(0x01, "a message ") + client_frame(0x80, "of two parts"));
  publish_seen(clients, 5);
  clients[0].send(client_frame(0x89, "ping"));
  const SocketMessage pong = clients[0].message();
  EXPECT_EQ(pong.kind, 10);
  EXPECT_EQ(pong.bytes, "ping");
  clients[0].send(client_frame(0x88, ""));
  EXPECT_EQ(clients[0].message().kind, 8);
  EXPECT_TRUE(clients[0].ends());
}

TEST_F(LiveServerTest, WhoIsOneTooManyIsTold) {
  options_.most_connections = 4;
  start();
  std::vector<PlainClient> clients;
  for (int i = 0; i < 4; ++i) clients.push_back(socket("/api/records"));
  PlainClient fifth = client();
  EXPECT_EQ(fifth.answer().status, 503);
  publish_seen(clients, 3);
  clients.pop_back();
  HttpAnswer answer;
  for (int i = 0; i < 500 && answer.status != 200; ++i) answer = get("/api/info");
  EXPECT_EQ(answer.status, 200) << "there is room again";
}

TEST_F(LiveServerTest, ClientsComeAndGo) {
  start();
  std::vector<PlainClient> clients;
  clients.push_back(socket("/api/records"));
  const int before = open_descriptors();
  for (int i = 0; i < 500; ++i) {
    PlainClient guest = client();
    const int way = i % 5;
    if (way == 0) guest.send(request("GET /api/info"));
    if (way == 1) guest.open_socket("/api/records");
    if (way == 2) guest.open_socket("/api/frames");
    if (way == 3) guest.send(request("GET /api/records.jsonl"));
    server_->publish(update_of(i, 640, 480));
    ASSERT_EQ(number_in(clients[0].message().bytes), i);
  }
  for (int i = 0; i < 500 && open_descriptors() > before; ++i) {
    server_->publish(update_of(1000 + i));
    ASSERT_EQ(number_in(clients[0].message().bytes), 1000 + i);
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_EQ(open_descriptors(), before);
}

TEST_F(LiveServerTest, AllConnectionsEndWithIt) {
  const int before = open_descriptors();
  start();
  {
    PlainClient socket_client = socket("/api/records");
    PlainClient watcher = socket("/api/frames");
    PlainClient reader = client();
    reader.send(request("GET /api/records.jsonl"));
    EXPECT_EQ(reader.answer().status, 200);
    PlainClient asker = client();
    asker.send("GET /api/info HTTP/1.1\r\n");
    for (int number = 0; number < 10; ++number) server_->publish(update_of(number));
    server_.reset();
    int last = -1;
    SocketMessage message = socket_client.message();
    for (; message.kind == kText; message = socket_client.message()) last = number_in(message.bytes);
    EXPECT_EQ(last, 9) << "what waits is handed over";
    EXPECT_EQ(message.kind, 8);
    EXPECT_TRUE(watcher.ends());
    EXPECT_TRUE(reader.ends());
    EXPECT_TRUE(asker.ends());
  }
  EXPECT_EQ(open_descriptors(), before);
}

TEST_F(LiveServerTest, APortInUseIsSaid) {
  start();
  options_.port = port_;
  EXPECT_THAT(error_of([&] { LiveServer({}, options_); }),
              Eq(fmt::format("port {} of 127.0.0.1 is in use by another program; choose another port, or 0 "
                             "for any that is free",
                             port_)));
  server_.reset();
  EXPECT_NO_THROW(LiveServer({}, options_)) << "the port is free at once";
}

TEST_F(LiveServerTest, ChecksItsOptions) {
  const auto error_with = [&](auto change) {
    LiveServerOptions options = options_;
    change(options);
    return error_of([&] { LiveServer({}, options); });
  };
  EXPECT_THAT(error_with([](auto& o) { o.port = 65536; }), HasSubstr("port is 65536"));
  EXPECT_THAT(error_with([](auto& o) { o.port = -1; }), HasSubstr("port is -1"));
  EXPECT_THAT(error_with([](auto& o) { o.host = "example.org"; }), HasSubstr("--host example.org"));
  EXPECT_THAT(error_with([](auto& o) { o.host = "203.0.113.77"; }),
              HasSubstr("203.0.113.77 cannot be served"));
  EXPECT_THAT(error_with([](auto& o) { o.most_connections = 0; }), HasSubstr("0 connections"));
  EXPECT_THAT(error_with([](auto& o) { o.request_s = 0.0; }), HasSubstr("limit of 0 s"));
  EXPECT_THAT(error_with([](auto& o) { o.most_connections = 4097; }), HasSubstr("4097 connections"));
  EXPECT_THAT(error_with([](auto& o) { o.request_s = std::nan(""); }), HasSubstr("limit of nan s"));
  EXPECT_THAT(error_with([](auto& o) { o.write_s = 3601.0; }), HasSubstr("limit of 3601 s"));
}

TEST_F(LiveServerTest, RecordingIsBegunAndEnded) {
  std::atomic<bool> is_on = false;
  start({.state = [&] { return RecordingState{.file = is_on ? "a.h5" : "", .frames = 3}; },
         .set =
             [&](bool on) {
               if (on && is_on) fail("it is on");
               is_on = on;
             }});
  const HttpAnswer on = post(R"({"on": true})");
  EXPECT_EQ(on.status, 200);
  EXPECT_EQ(json::parse(on.body)["recording"]["file"], "a.h5");
  EXPECT_TRUE(is_on);
  EXPECT_EQ(post(R"({"on": true})").status, 409);
  EXPECT_EQ(post(R"({"on": true})").body, "it is on\n");
  EXPECT_EQ(post(R"({"on": false, "file": "x"})").status, 400);
  EXPECT_EQ(post("on").status, 400);
  EXPECT_EQ(post(R"({"on": false})", "Host: evil.org\r\n").status, 403);
  EXPECT_EQ(post(R"({"on": false})", "Origin: http://evil.org\r\n").status, 403);
  EXPECT_TRUE(is_on);
  EXPECT_EQ(post(R"({"on": false})").status, 200);
  EXPECT_FALSE(is_on);
}

TEST_F(LiveServerTest, WithoutAPlaceThereIsNoRecording) {
  start();
  EXPECT_EQ(post(R"({"on": true})").status, 409);
  EXPECT_THAT(post(R"({"on": true})").body, HasSubstr("--record-folder"));
}

TEST_F(LiveServerTest, TakesFramesFromManyThreads) {
  start();
  PlainClient records = socket("/api/records");
  PlainClient frames = socket("/api/frames");
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      for (int k = 0; k < 50; ++k) server_->publish(update_of(100 * i + k));
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(records.message().kind, kText);
  EXPECT_EQ(frames.message().kind, kBinary);
}

}  // namespace
}  // namespace knuckle
