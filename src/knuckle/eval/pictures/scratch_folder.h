// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace knuckle {

/// A new empty folder among the system's temporary files, removed with all that is in it at the end of its
/// life.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace knuckle
