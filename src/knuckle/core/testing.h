// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "knuckle/core/error.h"

namespace knuckle::testing {

/// A new empty folder that is removed at the end of its life.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// The project's root, where committed fixtures are found.
std::filesystem::path project_folder();

/// Where the real recordings lie ($KNUCKLE_SHARED_DATA, else ../shared/data from the project's root); empty
/// where they are missing. A test that needs them starts with
///     KNUCKLE_REQUIRE_SHARED_DATA(folder);
std::filesystem::path shared_data_folder();

#define KNUCKLE_REQUIRE_SHARED_DATA(folder)                                      \
  const std::filesystem::path folder = ::knuckle::testing::shared_data_folder(); \
  if (folder.empty()) GTEST_SKIP() << "the shared recordings are not on this machine"

/// The message of the Error that `action` throws; fails the test where it throws none.
std::string error_of(const std::function<void()>& action);

}  // namespace knuckle::testing
