// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/testing.h"

#include <cstdlib>

#include <unistd.h>

namespace knuckle::testing {

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "knuckle_test_XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make a temporary folder");
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path project_folder() {
  return KNUCKLE_PROJECT_FOLDER;
}

std::filesystem::path shared_data_folder() {
  const char* chosen = std::getenv("KNUCKLE_SHARED_DATA");
  const std::filesystem::path folder =
      chosen != nullptr ? std::filesystem::path(chosen) : project_folder() / "../shared/data";
  return std::filesystem::is_directory(folder) ? folder : std::filesystem::path();
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "expected an Error, none was thrown";
  return {};
}

}  // namespace knuckle::testing
