// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/file_io.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include <fcntl.h>
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

/// Removes a temporary file at the end of its scope, unless it was renamed.
struct TemporaryFile {
  std::filesystem::path path;
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
};

std::filesystem::path temporary_name(const std::filesystem::path& path) {
  // Keeps the extension: writers such as OpenCV's choose their format by it.
  return path.parent_path() /
         fmt::format(".{}.{}.partial{}", path.stem().string(), ::getpid(), path.extension().string());
}

}  // namespace

void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(const std::filesystem::path&)>& write) {
  const TemporaryFile temporary{temporary_name(path)};
  write(temporary.path);
  publish_file(temporary.path, path);
}

void publish_file(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  flush_to_disk(temporary, path);
  std::error_code fault;
  std::filesystem::rename(temporary, path, fault);
  if (fault) fail("{}: cannot write: {}", path.string(), fault.message());
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
  if (std::filesystem::is_directory(path)) fail("{}: cannot write: it is a folder", path.string());
  const TemporaryFile temporary{temporary_name(path)};
  errno = 0;
  if (!std::ofstream(temporary.path)) fail("{}: cannot write: {}", path.string(), system_message(errno));
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code fault;
  std::filesystem::create_directories(folder, fault);
  if (fault) fail("{}: cannot make the folder: {}", folder.string(), fault.message());
}

}  // namespace knuckle
