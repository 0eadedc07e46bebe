// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <utility>

namespace knuckle {

/// Records that may wait for one client.
inline constexpr std::size_t kMostRecords = 64;

/// The records that wait for a client. Where it reads too slowly, the oldest are lost.
class WaitingRecords {
 public:
  void add(std::shared_ptr<const std::string> record) {
    if (records_.size() == kMostRecords) records_.pop_front();
    records_.push_back(std::move(record));
  }
  bool empty() const { return records_.empty(); }
  std::shared_ptr<const std::string> take() {
    auto record = std::move(records_.front());
    records_.pop_front();
    return record;
  }

 private:
  std::deque<std::shared_ptr<const std::string>> records_;
};

}  // namespace knuckle
