// SPDX-License-Identifier: Apache-2.0
// How options are set from a table of a TOML file; only options.cpp includes this.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

#include "knuckle/core/error.h"
#include "knuckle/core/option_faults.h"

namespace knuckle {

/// A node's type, for a person.
inline std::string type_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::string:
      return "a text";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::table:
      return "a table";
    default:
      return "a date or time";
  }
}

/// Sets options from the keys of a table. `Table` is OptionTable's state, which only it can name.
template <class Table>
class OptionReader final : public OptionVisitor {
 public:
  explicit OptionReader(Table& table) : table_(table) {}

  void real(std::string_view name, double& value, const Interval& range) override {
    if (const toml::node* node = table_.find(name)) {
      value = number(name, *node);
      require(name, range_fault(value, range));
    }
  }

  void integer(std::string_view name, int& value, const Interval& range) override {
    if (const toml::node* node = table_.find(name)) {
      const auto whole = whole_number(name, *node);
      require(name, range_fault(static_cast<double>(whole), range));
      if (whole < std::numeric_limits<int>::min() || whole > std::numeric_limits<int>::max()) {
        table_.fail_at(name, fmt::format("is {}, which is out of range", whole));
      }
      value = static_cast<int>(whole);
    }
  }

  void seed(std::string_view name, std::uint64_t& value) override {
    if (const toml::node* node = table_.find(name)) {
      const auto whole = whole_number(name, *node);
      if (whole < 0) table_.fail_at(name, fmt::format("is {}, expected at least 0", whole));
      value = static_cast<std::uint64_t>(whole);
    }
  }

  void flag(std::string_view name, bool& value) override {
    if (const toml::node* node = table_.find(name)) {
      if (!node->is_boolean()) wrong_type(name, "true or false", *node);
      value = node->as_boolean()->get();
    }
  }

  void text(std::string_view name, std::string& value) override {
    if (const toml::node* node = table_.find(name)) {
      if (!node->is_string()) wrong_type(name, "a text", *node);
      value = node->as_string()->get();
    }
  }

  void choice(std::string_view name, std::string& value, std::span<const std::string_view> known) override {
    text(name, value);
    if (table_.find(name) != nullptr) require(name, choice_fault(value, known));
  }

  void reals(std::string_view name, std::vector<double>& value, const Interval& range, std::size_t shortest,
             std::size_t longest) override {
    if (const toml::node* node = table_.find(name)) {
      value.clear();
      for (const toml::node& entry : list(name, *node)) value.push_back(number(name, entry));
      require(name, list_fault(value, range, shortest, longest));
    }
  }

  void texts(std::string_view name, std::vector<std::string>& value,
             std::span<const std::string_view> known) override {
    if (const toml::node* node = table_.find(name)) {
      value.clear();
      for (const toml::node& entry : list(name, *node)) {
        if (!entry.is_string()) wrong_type(name, "a list of texts", entry);
        value.push_back(entry.as_string()->get());
      }
      require(name, texts_fault(value, known));
    }
  }

 private:
  [[noreturn]] void wrong_type(std::string_view name, std::string_view expected,
                               const toml::node& node) const {
    table_.fail_at(name, fmt::format("expected {}, found {}", expected, type_of(node)));
  }

  void require(std::string_view name, const OptionFault& fault) const {
    if (fault) table_.fail_at(name, *fault);
  }

  double number(std::string_view name, const toml::node& node) const {
    if (node.is_integer()) return static_cast<double>(node.as_integer()->get());
    if (!node.is_floating_point()) wrong_type(name, "a number", node);
    return node.as_floating_point()->get();
  }

  std::int64_t whole_number(std::string_view name, const toml::node& node) const {
    if (!node.is_integer()) wrong_type(name, "a whole number", node);
    return node.as_integer()->get();
  }

  const toml::array& list(std::string_view name, const toml::node& node) const {
    if (!node.is_array()) wrong_type(name, "a list", node);
    return *node.as_array();
  }

  Table& table_;
};

}  // namespace knuckle
