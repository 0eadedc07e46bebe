// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace knuckle::testing {

/// A variable of the environment, for programs that are started during its life.
class EnvironmentVariable {
 public:
  EnvironmentVariable(const char* name, const std::string& value);
  ~EnvironmentVariable();
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

/// The address sanitizer's options, with those that it needs where a library of ours comes before its own.
std::string sanitizer_beside_a_library();

}  // namespace knuckle::testing
