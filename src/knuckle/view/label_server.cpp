// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/label_server.h"

#include <charconv>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/view/request_access.h"

namespace knuckle {
namespace {

constexpr std::size_t kMostWaiting = 256;  // requests
constexpr std::chrono::milliseconds kRest{200};
/// That a page which opens has the processor to itself, as far as that is ours: it draws for the first time.
constexpr std::chrono::milliseconds kOpening{2000};
constexpr int kBadRequest = 400;
constexpr int kNotFound = 404;
constexpr int kNotAllowed = 405;
constexpr int kConflict = 409;
constexpr int kUnavailable = 503;

WebAnswer bytes_answer(const std::vector<std::uint8_t>& bytes) {
  return {.status = 200,
          .content_type = "application/octet-stream",
          .body = std::string(bytes.begin(), bytes.end()),
          .allow = {}};
}

/// A whole number of the query. Throws an Error where it is missing or none.
std::int64_t number_in(const WebRequest& request, std::string_view name) {
  const std::string_view text = query_value(request.query, name);
  std::int64_t number = 0;
  const auto [rest, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc() || rest != text.data() + text.size())
    fail("expected a whole number as '{}' in the address", name);
  return number;
}

}  // namespace

class LabelServer::Impl {
 public:
  Impl(LabelInfo info, LabelSession& session, const WebServerOptions& options)
      : info_(std::move(info)), session_(session), server_(service(), options) {
    session_.changed = [this](HandKey hand, std::int64_t revision) { tell(hand, revision); };
    answering_ = std::thread([this] { answer_requests(); });
    working_ = std::thread([this] { work(); });
  }
  ~Impl() {
    {
      const std::lock_guard lock(mutex_);
      is_ending_ = true;
    }
    wake_.notify_all();
    answering_.join();
    working_.join();
    session_.changed = nullptr;
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const std::string& address() const { return server_.address(); }

 private:
  using Job = std::pair<WebRequest, WebReply>;

  WebService service() {
    return {
        .answer = [this](const WebRequest& request, const WebReply& reply) { return take(request, reply); },
        .feeds = {{"/api/changes", WebFeed::texts}},
        .without_socket = {}};
  }

  /// Called by the server's thread: what is the service's waits for its turn.
  bool take(const WebRequest& request, const WebReply& reply) {
    if (!request.path.starts_with("/api/") || request.path == "/api/changes") return false;
    {
      const std::lock_guard lock(mutex_);
      if (is_ending_ || jobs_.size() >= kMostWaiting) {
        reply(sentence_answer(kUnavailable, "Too many requests wait here."));
        return true;
      }
      jobs_.emplace_back(request, reply);
      if (request.path == "/api/info") opened_ = std::chrono::steady_clock::now();
    }
    wake_.notify_all();
    return true;
  }

  void answer_requests() {
    while (const std::optional<Job> job = next_job()) {
      WebAnswer answer;
      try {
        answer = answer_to(job->first);
      } catch (const Error& error) {
        answer = sentence_answer(kBadRequest, error.what());
      } catch (const std::exception&) {  // out of memory, say: that of one request
        answer = sentence_answer(kUnavailable, "There is no memory for that.");
      }
      job->second(std::move(answer));
    }
  }
  std::optional<Job> next_job() {
    std::unique_lock lock(mutex_);
    is_busy_ = false;
    wake_.wait(lock, [this] { return is_ending_ || !jobs_.empty(); });
    if (jobs_.empty()) return std::nullopt;
    is_busy_ = true;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    return job;
  }

  WebAnswer answer_to(const WebRequest& request) {
    if (request.is_post != (request.path == "/api/labels")) {
      WebAnswer refusal = sentence_answer(kNotAllowed, "This is not served in this way.");
      refusal.allow = request.is_post ? "GET, HEAD" : "POST";
      return refusal;
    }
    if (request.path == "/api/info") return {.body = label_info_message(info_, session_.head())};
    if (request.path == "/api/standings")
      return {.body = standings_message(session_.standings(), session_.seconds_of_verified())};
    if (request.path == "/api/next") return next_frame(number_in(request, "after"));
    if (request.path == "/api/frame") {
      return bytes_answer(
          labelled_frame_message(session_.frame(number_in(request, "index")), session_.head().convention));
    }
    if (request.path == "/api/thumbnail")
      return bytes_answer(thumbnail_message(*session_.image(number_in(request, "index"))));
    if (request.path == "/api/labels") return change(request.body);
    return sentence_answer(kNotFound, "There is nothing of this name.");
  }

  WebAnswer next_frame(std::int64_t after) const {
    if (after < 0 || after >= session_.head().frames) fail("there is no frame {}", after);
    const auto next = session_.proposed(after);
    return {.body = next ? fmt::format(R"({{"frame":{}}})", *next) : R"({"frame":null})"};
  }

  WebAnswer change(const std::string& body) {
    const LabelAnswer answer = session_.apply(parse_label_request(body, session_.head()));
    wake_.notify_all();  // neighbours may follow
    WebAnswer said{.body = label_answer_message(answer, session_.head().convention, session_.fault(),
                                                session_.waiting())};
    if (answer.is_refused) said.status = kConflict;
    return said;
  }

  void tell(HandKey hand, std::int64_t revision) {
    std::string text = fmt::format(R"({{"frame":{},"side":"{}","revision":{}}})", hand.frame,
                                   hand.side == HandSide::left ? "left" : "right", revision);
    server_.publish(
        std::make_shared<const WebUpdate>(WebUpdate{.text = [text = std::move(text)] { return text; },
                                                    .image = [] { return std::vector<std::uint8_t>(); }}));
  }

  /// While nobody asks: a person who waits comes first.
  void work() {
    while (true) {
      {
        std::unique_lock lock(mutex_);
        if (is_idle_) wake_.wait_for(lock, kRest);
        while (is_busy_ && !is_ending_) wake_.wait_for(lock, std::chrono::milliseconds(5));
        if (is_ending_) return;
      }
      is_idle_ = !session_.follow() && (is_opening() || !session_.prepare());
    }
  }

  bool is_opening() {
    const std::lock_guard lock(mutex_);
    return opened_ && std::chrono::steady_clock::now() - *opened_ < kOpening;
  }

  LabelInfo info_;
  LabelSession& session_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Job> jobs_;
  std::optional<std::chrono::steady_clock::time_point> opened_;  ///< when a page last was
  bool is_ending_ = false;
  bool is_busy_ = false;  ///< a request is being answered
  bool is_idle_ = false;  ///< of the working thread: there was nothing to do
  WebServer server_;      ///< ends before what it asks, and after both threads
  std::thread answering_;
  std::thread working_;
};

LabelServer::LabelServer(LabelInfo info, LabelSession& session, const WebServerOptions& options)
    : impl_(std::make_unique<Impl>(std::move(info), session, options)) {}

LabelServer::~LabelServer() = default;

const std::string& LabelServer::address() const {
  return impl_->address();
}

}  // namespace knuckle
