// SPDX-License-Identifier: Apache-2.0
#include "environment_variable.h"

#include <cstdlib>

namespace knuckle::testing {

EnvironmentVariable::EnvironmentVariable(const char* name, const std::string& value) : name_(name) {
  if (const char* const before = std::getenv(name)) before_ = before;
  ::setenv(name, value.c_str(), 1);
}

EnvironmentVariable::~EnvironmentVariable() {
  if (before_)
    ::setenv(name_, before_->c_str(), 1);
  else
    ::unsetenv(name_);
}

std::string sanitizer_beside_a_library() {
  const char* const before = std::getenv("ASAN_OPTIONS");
  return std::string(before == nullptr ? "" : before) + ":verify_asan_link_order=0";
}

}  // namespace knuckle::testing
