// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/work_claim.h"

#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

constexpr std::chrono::milliseconds kLookEvery{100};

[[noreturn]] void fail_to_lock(const fs::path& file, int code) {
  fail("{}: cannot be locked: {}; expected a folder that can be written, on a disk that has locks",
       file.string(), std::generic_category().message(code));
}

/// Whether the file that is open still has that name: who had the claim before has removed it in the end.
bool is_at(int descriptor, const fs::path& file) {
  struct stat opened {};
  struct stat named {};
  return ::fstat(descriptor, &opened) == 0 && ::lstat(file.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

/// The file, open and locked; -1 where somebody else has the lock.
int tried(const fs::path& file) {
  constexpr int kMode = 0666;
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, kMode);
  if (descriptor < 0) fail_to_lock(file, errno);
  const bool is_locked = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  const int fault = errno;
  if (is_locked && is_at(descriptor, file)) return descriptor;
  ::close(descriptor);
  if (!is_locked && fault != EWOULDBLOCK && fault != EINTR) fail_to_lock(file, fault);
  return -1;
}

}  // namespace

WorkClaim::WorkClaim(fs::path file, const std::function<void()>& on_wait) : file_(std::move(file)) {
  descriptor_ = tried(file_);
  if (descriptor_ >= 0) return;
  on_wait();
  while (descriptor_ < 0) {
    end_if_interrupted();
    std::this_thread::sleep_for(kLookEvery);
    descriptor_ = tried(file_);
  }
}

WorkClaim::~WorkClaim() {
  ::unlink(file_.c_str());  // before the lock goes, so that it is never another's
  ::close(descriptor_);
}

}  // namespace knuckle
