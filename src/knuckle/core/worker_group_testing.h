// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <atomic>
#include <barrier>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "knuckle/core/worker_group.h"
#include "knuckle/core/worker_messages.h"

namespace knuckle::testing {

/// Workers that are threads of one process.
class ThreadWorkers {
 public:
  explicit ThreadWorkers(int size) : sent_(static_cast<std::size_t>(size)), all_(size) {}

  class Worker final : public WorkerGroup {
   public:
    Worker(ThreadWorkers& group, int rank) : group_(group), rank_(rank) {}
    int rank() const override { return rank_; }
    int size() const override { return static_cast<int>(group_.sent_.size()); }
    double seconds_in_exchange() const override { return 0.0; }
    std::int64_t bytes_sent() const override { return 0; }

    std::vector<std::byte> exchange(Messages sent, const std::vector<std::int64_t>& sizes) override {
      const auto own = static_cast<std::size_t>(rank_);
      group_.sent_[own] = std::move(sent);
      group_.all_.arrive_and_wait();
      if (group_.is_one_lost_) throw std::runtime_error("a worker is lost");
      std::vector<std::byte> received;
      for (std::size_t k = 0; k < sizes.size(); ++k) {
        const Messages& from = group_.sent_[k];
        std::int64_t begin = 0;
        for (std::size_t to = 0; to < own; ++to) begin += from.sizes[to];
        EXPECT_EQ(from.sizes[own], sizes[k]) << "what is announced is what comes";
        received.insert(received.end(), from.bytes.begin() + begin,
                        from.bytes.begin() + begin + from.sizes[own]);
      }
      group_.all_.arrive_and_wait();
      return received;
    }

   private:
    ThreadWorkers& group_;
    int rank_;
  };

  /// Runs the work of every worker at once; throws what the first of them has thrown. The others lose it at
  /// their next exchange.
  void run(const std::function<void(WorkerGroup&)>& work) {
    std::exception_ptr fault;
    std::mutex mutex;
    {
      std::vector<std::jthread> threads;
      for (int rank = 0; rank < static_cast<int>(sent_.size()); ++rank) {
        threads.emplace_back([&, rank] {
          Worker worker(*this, rank);
          try {
            work(worker);
          } catch (...) {
            const std::lock_guard lock(mutex);
            if (!fault) fault = std::current_exception();
            is_one_lost_ = true;
            all_.arrive_and_drop();
          }
        });
      }
    }
    if (fault) std::rethrow_exception(fault);
  }

 private:
  std::vector<Messages> sent_;
  std::barrier<> all_;
  std::atomic<bool> is_one_lost_ = false;
};

/// Worker 0 of two, whose other worker says these messages, one after another, whatever it is asked.
class ToldWorkers final : public WorkerGroup {
 public:
  explicit ToldWorkers(std::vector<std::vector<std::byte>> told) : told_(std::move(told)) {}

  int rank() const override { return 0; }
  int size() const override { return 2; }
  std::vector<std::byte> exchange(Messages sent, const std::vector<std::int64_t>& sizes) override {
    std::vector<std::byte> received(sent.bytes.begin(), sent.bytes.begin() + sent.sizes[0]);
    if (next_ == told_.size()) throw std::runtime_error("the other worker says nothing more");
    const std::vector<std::byte>& told = told_[next_++];
    EXPECT_EQ(std::ssize(told), sizes[1]) << "message " << next_;
    received.insert(received.end(), told.begin(), told.end());
    return received;
  }
  double seconds_in_exchange() const override { return 0.0; }
  std::int64_t bytes_sent() const override { return 0; }

 private:
  std::vector<std::vector<std::byte>> told_;
  std::size_t next_ = 0;
};

/// Values as one message.
template <class... Values>
std::vector<std::byte> message_of(const Values&... values) {
  std::vector<std::byte> message;
  (append_value(message, values), ...);
  return message;
}

}  // namespace knuckle::testing
