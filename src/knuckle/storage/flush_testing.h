// SPDX-License-Identifier: Apache-2.0
// For tests of what is handed to the disk, and when; one file of a test program may include it or several.
#pragma once

#include <cerrno>
#include <filesystem>
#include <functional>
#include <string>

#include <sys/syscall.h>
#include <unistd.h>

namespace knuckle::testing {

/// Is shown each file and folder that this program hands to the disk, before it gets there.
inline std::function<void(const std::filesystem::path&)> on_flush;
/// Whether nothing that is handed to the disk arrives there.
inline bool disk_fails = false;

}  // namespace knuckle::testing

// This takes the place of the system's: what it was asked shows nowhere else.
extern "C" [[gnu::used]] inline int fsync(int descriptor) {
  using namespace knuckle::testing;
  if (on_flush) on_flush(std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor)));
  if (disk_fails) {
    errno = EIO;
    return -1;
  }
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}
