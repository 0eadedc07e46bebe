// SPDX-License-Identifier: Apache-2.0
// For tests only; not part of the library.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>
#include <utility>

namespace knuckle::testing {

/// Gives an environment variable another value, and its former one, or none, at the end of its life.
class ChangedVariable {
 public:
  ChangedVariable(std::string name, const std::string& value) : name_(std::move(name)) {
    if (const char* const former = std::getenv(name_.c_str())) former_ = former;
    ::setenv(name_.c_str(), value.c_str(), 1);
  }
  ~ChangedVariable() {
    if (former_) {
      ::setenv(name_.c_str(), former_->c_str(), 1);
    } else {
      ::unsetenv(name_.c_str());
    }
  }
  ChangedVariable(const ChangedVariable&) = delete;
  ChangedVariable& operator=(const ChangedVariable&) = delete;

 private:
  std::string name_;
  std::optional<std::string> former_;
};

}  // namespace knuckle::testing
