// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/file_io.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

std::string system_message(int code) {
  return std::generic_category().message(code);
}

/// Hands a file to the disk, so that a rename cannot overtake its content.
void flush_to_disk(const std::filesystem::path& path, const std::filesystem::path& named) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) fail("{}: cannot write: {}", named.string(), system_message(errno));
  const int result = ::fsync(descriptor);
  const int code = errno;
  ::close(descriptor);
  if (result != 0) fail("{}: cannot write: {}", named.string(), system_message(code));
}

/// 64 random bits: nobody can put a file or a link where ours will lie.
std::string unpredictable_name() {
  std::uint64_t number = 0;
  while (::getrandom(&number, sizeof(number), 0) != sizeof(number)) {
  }
  return fmt::format("{:016x}", number);
}

/// Keeps the extension: writers such as OpenCV's choose their format by it.
std::filesystem::path temporary_name(const std::filesystem::path& path) {
  return path.parent_path() / fmt::format(".{}.{}.partial{}", path.stem().string(), unpredictable_name(),
                                          path.extension().string());
}

/// A file, or a link, takes the place of another one; a device, a pipe or a socket must not.
void require_replaceable(const std::filesystem::path& path) {
  if (path.empty()) fail("a file to write has an empty name");
  std::error_code ignored;
  const auto status = std::filesystem::symlink_status(path, ignored);
  if (std::filesystem::is_directory(status)) fail("{}: cannot write: it is a folder", path.string());
  if (std::filesystem::is_other(status)) {
    fail("{}: cannot write: it is a device, a pipe or a socket, expected a file or a new name",
         path.string());
  }
}

/// A new, empty file beside `named`; removed at the end of its scope, unless it was renamed.
struct TemporaryFile {
  std::filesystem::path path;

  explicit TemporaryFile(const std::filesystem::path& named) : path(temporary_name(named)) {
    require_replaceable(named);
    constexpr int kMode = 0666;
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kMode);
    if (descriptor < 0) fail("{}: cannot write: {}", named.string(), system_message(errno));
    ::close(descriptor);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
};

}  // namespace

void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(const std::filesystem::path&)>& write) {
  const TemporaryFile temporary(path);
  write(temporary.path);
  publish_file(temporary.path, path);
}

void publish_file(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  require_replaceable(path);
  flush_to_disk(temporary, path);
  std::error_code fault;
  std::filesystem::rename(temporary, path, fault);
  if (fault) fail("{}: cannot write: {}", path.string(), fault.message());
  sync_folder_of(path);
}

void sync_folder_of(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

void write_text_file(const std::filesystem::path& path, std::string_view text) {
  write_file_atomically(path, [&](const std::filesystem::path& temporary) {
    errno = 0;
    std::ofstream stream(temporary, std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.close();
    if (!stream) fail("{}: cannot write: {}", path.string(), system_message(errno));
  });
}

void check_writable(const std::filesystem::path& path) {
  const TemporaryFile temporary(path);
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code fault;
  std::filesystem::create_directories(folder, fault);
  if (fault) fail("{}: cannot make the folder: {}", folder.string(), fault.message());
}

}  // namespace knuckle
