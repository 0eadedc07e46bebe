// SPDX-License-Identifier: Apache-2.0
// Private to the modules of networks.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace knuckle {

/// Lends room to work in to as many callers at once as there are, and keeps it for the next ones: fresh pages
/// for each call would cost a tenth of a small network's time.
template <class Workspace>
class WorkspacePool {
 public:
  explicit WorkspacePool(std::function<Workspace()> make) : make_(std::move(make)) {}

  /// Returns `work(workspace)`. Whatever the workspace holds is from before.
  template <class Work>
  auto with_workspace(const Work& work) const {
    std::unique_ptr<Workspace> workspace = take();
    auto result = work(*workspace);
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(workspace));
    return result;
  }

 private:
  std::unique_ptr<Workspace> take() const {
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        std::unique_ptr<Workspace> workspace = std::move(free_.back());
        free_.pop_back();
        return workspace;
      }
    }
    return std::make_unique<Workspace>(make_());
  }

  std::function<Workspace()> make_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> free_;
};

}  // namespace knuckle
