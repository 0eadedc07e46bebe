// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/live_server.h"

#include <mutex>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/view/control_message.h"

namespace knuckle {

class LiveServer::Impl {
 public:
  Impl(LiveInfo info, const LiveServerOptions& options, RecordingControl recording)
      : info_(std::move(info)), recording_(std::move(recording)), server_(service(), options) {}

  const std::string& address() const { return server_.address(); }

  void publish(std::shared_ptr<const LiveUpdate> update) {
    {
      const std::lock_guard lock(mutex_);
      newest_ = update;
    }
    server_.publish(std::make_shared<const WebUpdate>(
        WebUpdate{.text = [update] { return to_json_line(update->record); },
                  .image = [update = std::move(update)] { return frame_message(*update); }}));
  }

 private:
  WebService service() {
    return {
        .answer = [this](const WebRequest& request, const WebReply& reply) { return answer(request, reply); },
        .feeds = {{"/api/records", WebFeed::texts},
                  {"/api/frames", WebFeed::images},
                  {"/api/records.jsonl", WebFeed::lines}},
        .without_socket = " Records are at /api/records.jsonl without one."};
  }

  bool answer(const WebRequest& request, const WebReply& reply) const {
    if (request.path == "/api/info" && !request.is_post) {
      reply({.body = info()});
    } else if (request.path == "/api/recording") {
      reply(set_recording(request));
    } else {
      return false;
    }
    return true;
  }

  std::string info() const {
    std::shared_ptr<const LiveUpdate> newest;
    {
      const std::lock_guard lock(mutex_);
      newest = newest_;
    }
    return info_message(info_, recording_.state(), newest.get());
  }

  WebAnswer set_recording(const WebRequest& request) const {
    constexpr int kBadRequest = 400;
    constexpr int kNotAllowed = 405;
    constexpr int kConflict = 409;
    if (!request.is_post) {
      WebAnswer refusal = sentence_answer(kNotAllowed, "Only POST is served here.");
      refusal.allow = "POST";
      return refusal;
    }
    RecordingRequest wanted;
    try {
      wanted = parse_recording_request(request.body);
    } catch (const Error& error) {
      return sentence_answer(kBadRequest, error.what());
    }
    if (!info_.can_record || !recording_.set) {
      return sentence_answer(kConflict,
                             "There is no place for recordings: start the program with --record-folder.");
    }
    try {
      recording_.set(wanted.on);
    } catch (const Error& error) {
      return sentence_answer(kConflict, error.what());
    }
    return {.body = info()};
  }

  LiveInfo info_;
  RecordingControl recording_;
  mutable std::mutex mutex_;
  std::shared_ptr<const LiveUpdate> newest_;  ///< null before the first
  WebServer server_;                          ///< the last: it asks the others
};

bool has_live_server() {
  return has_web_server();
}

LiveServer::LiveServer(LiveInfo info, const LiveServerOptions& options, RecordingControl recording)
    : impl_(std::make_unique<Impl>(std::move(info), options, std::move(recording))) {}

LiveServer::~LiveServer() = default;

const std::string& LiveServer::address() const {
  return impl_->address();
}

void LiveServer::publish(std::shared_ptr<const LiveUpdate> update) {
  impl_->publish(std::move(update));
}

}  // namespace knuckle
