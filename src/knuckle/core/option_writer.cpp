// SPDX-License-Identifier: Apache-2.0
#include <sstream>

#include <toml++/toml.h>

#include "knuckle/core/options.h"

namespace knuckle {
namespace {

/// Collects `key = value` lines. The TOML library quotes texts and keeps numbers exact.
class Writer final : public OptionVisitor {
 public:
  void real(std::string_view name, double& value, const Interval&) override {
    line(name, toml::value<double>(value));
  }
  void integer(std::string_view name, int& value, const Interval&) override {
    line(name, toml::value<std::int64_t>(value));
  }
  void seed(std::string_view name, std::uint64_t& value) override {
    line(name, toml::value<std::int64_t>(static_cast<std::int64_t>(value)));
  }
  void flag(std::string_view name, bool& value) override { line(name, toml::value<bool>(value)); }
  void text(std::string_view name, std::string& value) override {
    line(name, toml::value<std::string>(value));
  }
  void choice(std::string_view name, std::string& value, std::span<const std::string_view>) override {
    text(name, value);
  }
  void reals(std::string_view name, std::vector<double>& value, const Interval&, std::size_t,
             std::size_t) override {
    list(name, value);
  }
  void texts(std::string_view name, std::vector<std::string>& value,
             std::span<const std::string_view>) override {
    list(name, value);
  }

  std::string lines() const { return stream_.str(); }

 private:
  template <class Node>
  void line(std::string_view name, const Node& node) {
    stream_ << name << " = " << node << "\n";
  }

  template <class Values>
  void list(std::string_view name, const Values& values) {
    toml::array array;
    for (const auto& value : values) array.push_back(value);
    line(name, array);
  }

  std::ostringstream stream_;
};

}  // namespace

std::string detail::visited_as_toml(const std::function<void(OptionVisitor&)>& show_options) {
  Writer writer;
  show_options(writer);
  return writer.lines();
}

}  // namespace knuckle
