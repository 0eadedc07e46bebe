// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/regular_file.h"

#include <algorithm>
#include <cerrno>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

[[noreturn]] void fail_to_read(const std::filesystem::path& path) {
  fail("{}: cannot read: {}", path.string(), std::generic_category().message(errno));
}

std::string_view kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a FIFO (a named pipe)";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

void require_regular(const struct stat& status, const std::filesystem::path& path) {
  if (!S_ISREG(status.st_mode)) {
    fail("{}: expected a file, found {}", path.string(), kind_of(status.st_mode));
  }
}

}  // namespace

void require_regular_file(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) fail_to_read(path);
  require_regular(status, path);
}

RegularFile::RegularFile(const std::filesystem::path& path) : descriptor_(-1) {
  require_regular_file(path);  // before it is opened: opening a device may do something
  // Opening a FIFO waits for somebody who writes, unless told not to.
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor_ < 0) fail_to_read(path);
  try {
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0) fail_to_read(path);
    require_regular(status, path);
    size_ = static_cast<std::uint64_t>(status.st_size);
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

RegularFile::~RegularFile() {
  ::close(descriptor_);
}

std::string read_regular_file(const std::filesystem::path& path, std::int64_t most_bytes) {
  const RegularFile file(path);
  const auto fail_if_large = [&](std::int64_t bytes) {
    if (bytes > most_bytes) {
      fail("{}: the file has {} bytes or more, expected at most {}", path.string(), bytes, most_bytes);
    }
  };
  fail_if_large(static_cast<std::int64_t>(file.size()));
  // One more than its size: the end is found without another turn. Files of /proc have size 0 and content.
  constexpr std::size_t kLeast = 4096;
  std::string bytes(std::max(kLeast, static_cast<std::size_t>(file.size()) + 1), '\0');
  std::size_t length = 0;
  while (true) {
    const ssize_t count = ::read(file.descriptor(), bytes.data() + length, bytes.size() - length);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail_to_read(path);
    if (count == 0) break;
    length += static_cast<std::size_t>(count);
    fail_if_large(static_cast<std::int64_t>(length));
    if (length == bytes.size()) bytes.resize(2 * bytes.size());
  }
  bytes.resize(length);
  return bytes;
}

}  // namespace knuckle
