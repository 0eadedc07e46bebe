// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/open_own_file.h"

#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/regular_file.h"

namespace knuckle {

int open_own_file(const std::filesystem::path& path, int flags) {
  constexpr int kMode = 0666;
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | flags, kMode);
  if (descriptor < 0) return descriptor;
  try {
    require_regular_file(path);
  } catch (...) {
    ::close(descriptor);
    throw;
  }
  return descriptor;
}

int open_own_file_alone(const std::filesystem::path& path, int flags, const char* in_use) {
  const int descriptor = open_own_file(path, flags);
  if (descriptor < 0) fail("{}: cannot write: {}", path.string(), std::generic_category().message(errno));
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return descriptor;
  ::close(descriptor);
  fail("{}: {}", path.string(), in_use);
}

}  // namespace knuckle
