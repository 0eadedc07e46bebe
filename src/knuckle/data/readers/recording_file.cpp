// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/recording_file.h"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "knuckle/core/error.h"

namespace knuckle {

RecordingFile::RecordingFile(std::filesystem::path path) : path_(std::move(path)), file_(path_) {}

std::string RecordingFile::place(std::uint64_t at) const {
  return fmt::format("{}: at byte {}", path_.string(), at);
}

std::vector<std::uint8_t> RecordingFile::read(std::uint64_t at, std::uint64_t count) const {
  if (at > size() || count > size() - at) fail("{}: {} bytes lie beyond the end", place(at), count);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(count));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got =
        ::pread(file_.descriptor(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(at + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("{}: cannot read: {}", path_.string(), std::generic_category().message(errno));
    if (got == 0) fail("{}: was changed while it was read: it was cut short", path_.string());
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

std::vector<std::uint8_t> RecordingFile::read_up_to(std::uint64_t at, std::uint64_t count,
                                                    std::uint64_t end) const {
  return read(at, at > end ? 0 : std::min(count, end - at));
}

}  // namespace knuckle
