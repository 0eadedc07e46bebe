// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/options.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <type_traits>

#include <toml++/toml.h>

#include "knuckle/core/file_io.h"
#include "knuckle/core/text.h"

namespace knuckle {

bool Interval::contains(double value) const {
  const bool above_low = low_open ? value > low : value >= low;
  const bool below_high = high_open ? value < high : value <= high;
  return above_low && below_high;
}

std::string Interval::text() const {
  return fmt::format("{}{}, {}{}", low_open ? "(" : "[", low, high, high_open ? ")" : "]");
}

struct OptionTable::State {
  std::string origin;
  std::filesystem::path folder;
  std::shared_ptr<const toml::table> document;  // keeps `table` alive
  const toml::table* table = nullptr;           // null where the document lacks this table
  std::string path;                             // as in "segmentation" or "refine[1]"; empty for the root
  std::set<std::string, std::less<>> known;     // keys that were asked for
  std::map<std::string, std::vector<std::shared_ptr<State>>, std::less<>> children;
  std::string resolved;  // `key = value` lines of what was read, defaults included

  const toml::node* find(std::string_view key) {
    known.emplace(key);
    return table == nullptr ? nullptr : table->get(key);
  }

  std::string key_path(std::string_view key) const {
    return path.empty() ? std::string(key) : path + "." + std::string(key);
  }

  [[noreturn]] void fail_at(std::string_view key, std::string_view message) const {
    const toml::node* node = table == nullptr ? nullptr : table->get(key);
    const auto line = node != nullptr    ? node->source().begin.line
                      : table != nullptr ? table->source().begin.line
                                         : 0;
    if (line == 0) fail("{}: {}: {}", origin, key_path(key), message);
    fail("{}:{}: {}: {}", origin, line, key_path(key), message);
  }

  std::string known_keys() const { return joined(std::vector<std::string>(known.begin(), known.end())); }

  void finish() const {
    if (table != nullptr) {
      for (const auto& [key, node] : *table) {
        if (!known.contains(key.str()))
          fail_at(key.str(), fmt::format("unknown key; known are {}", known_keys()));
      }
    }
    for (const auto& [key, states] : children) {
      for (const auto& child : states) child->finish();
    }
  }

  std::string resolved_toml() const {
    std::string text = resolved;
    for (const auto& [key, states] : children) {
      const bool is_list = table != nullptr && table->get(key) != nullptr && table->get(key)->is_array();
      for (const auto& child : states) {
        text +=
            fmt::format(fmt::runtime(is_list ? "\n[[{}]]\n{}" : "\n[{}]\n{}"), key, child->resolved_toml());
      }
    }
    return text;
  }

  std::shared_ptr<State> child(const toml::table* child_table, std::string child_path) const {
    auto state = std::make_shared<State>();
    state->origin = origin;
    state->folder = folder;
    state->document = document;
    state->table = child_table;
    state->path = std::move(child_path);
    return state;
  }
};

namespace {

std::string quoted_list(std::span<const std::string_view> known) {
  std::vector<std::string> quoted;
  for (const std::string_view name : known) quoted.push_back(fmt::format("\"{}\"", name));
  return joined(quoted);
}

bool is_known(std::string_view value, std::span<const std::string_view> known) {
  return std::ranges::find(known, value) != known.end();
}

std::string type_of(const toml::node& node) {
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

/// What is wrong with a value, if anything. Each kind of option has one such function, for reading and
/// checking.
using Fault = std::optional<std::string>;

Fault range_fault(double value, const Interval& range) {
  if (range.contains(value)) return std::nullopt;
  return fmt::format("is {}, expected a value in {}", value, range.text());
}

Fault choice_fault(std::string_view value, std::span<const std::string_view> known) {
  if (is_known(value, known)) return std::nullopt;
  return fmt::format("is \"{}\", expected one of {}", value, quoted_list(known));
}

Fault list_fault(const std::vector<double>& values, const Interval& range, std::size_t shortest,
                 std::size_t longest) {
  if (values.size() < shortest || values.size() > longest) {
    return fmt::format(
        "holds {} numbers, expected {}", values.size(),
        shortest == longest ? fmt::format("{}", shortest) : fmt::format("{} to {}", shortest, longest));
  }
  for (const double value : values) {
    if (Fault fault = range_fault(value, range)) return "one " + *fault;
  }
  return std::nullopt;
}

Fault texts_fault(const std::vector<std::string>& values, std::span<const std::string_view> known) {
  if (known.empty()) return std::nullopt;
  for (const std::string& value : values) {
    if (Fault fault = choice_fault(value, known)) return "one " + *fault;
  }
  return std::nullopt;
}

/// Sets options from the keys of a table. `Table` is OptionTable's state, which only it can name.
template <class Table>
class Reader final : public OptionVisitor {
 public:
  explicit Reader(Table& table) : table_(table) {}

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

  void require(std::string_view name, const Fault& fault) const {
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

class Checker final : public OptionVisitor {
 public:
  explicit Checker(std::string_view what) : what_(what) {}

  void real(std::string_view name, double& value, const Interval& range) override {
    require(name, range_fault(value, range));
  }
  void integer(std::string_view name, int& value, const Interval& range) override {
    require(name, range_fault(value, range));
  }
  void seed(std::string_view, std::uint64_t&) override {}
  void flag(std::string_view, bool&) override {}
  void text(std::string_view, std::string&) override {}
  void choice(std::string_view name, std::string& value, std::span<const std::string_view> known) override {
    require(name, choice_fault(value, known));
  }
  void reals(std::string_view name, std::vector<double>& value, const Interval& range, std::size_t shortest,
             std::size_t longest) override {
    require(name, list_fault(value, range, shortest, longest));
  }
  void texts(std::string_view name, std::vector<std::string>& value,
             std::span<const std::string_view> known) override {
    require(name, texts_fault(value, known));
  }

 private:
  void require(std::string_view name, const Fault& fault) const {
    if (fault) fail("{}: {} {}", what_, name, *fault);
  }

  std::string_view what_;
};

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

OptionTable::OptionTable(std::shared_ptr<State> state) : state_(std::move(state)) {}

OptionTable OptionTable::load(const std::filesystem::path& path) {
  OptionTable table = parse(read_text_file(path), path.string());
  table.state_->folder = path.parent_path();
  return table;
}

OptionTable OptionTable::parse(std::string_view toml, const std::string& origin) {
  auto state = std::make_shared<State>();
  state->origin = origin;
  try {
    state->document = std::make_shared<const toml::table>(toml::parse(toml));
  } catch (const toml::parse_error& error) {
    fail("{}:{}: no valid TOML: {}", origin, error.source().begin.line, error.description());
  }
  state->table = state->document.get();
  return OptionTable(std::move(state));
}

void OptionTable::visit(const std::function<void(OptionVisitor&)>& show_options) const {
  Reader<State> reader(*state_);
  show_options(reader);
  const std::string lines = detail::visited_as_toml(show_options);
  const bool is_repeated = state_->resolved.find(lines) != std::string::npos;  // read by two components
  if (!is_repeated) state_->resolved += lines;
}

bool OptionTable::has(std::string_view key) const {
  return state_->table != nullptr && state_->table->contains(key);
}

std::string OptionTable::required_text(std::string_view key) const {
  if (state_->find(key) == nullptr) fail_at(key, "is missing, expected a text");
  return text_or(key, "");
}

std::string OptionTable::text_or(std::string_view key, std::string_view otherwise) const {
  std::string value(otherwise);
  visit([&](OptionVisitor& visitor) { visitor.text(key, value); });
  return value;
}

std::string OptionTable::choice_or(std::string_view key, std::string_view otherwise,
                                   std::span<const std::string_view> known) const {
  std::string value(otherwise);
  visit([&](OptionVisitor& visitor) { visitor.choice(key, value, known); });
  return value;
}

OptionTable OptionTable::table(std::string_view key) const {
  const toml::node* node = state_->find(key);
  if (node != nullptr && !node->is_table()) fail_at(key, "expected a table, found " + type_of(*node));
  auto& opened = state_->children[std::string(key)];
  if (opened.empty()) {
    opened.push_back(state_->child(node == nullptr ? nullptr : node->as_table(), state_->key_path(key)));
  }
  return OptionTable(opened.front());
}

std::vector<OptionTable> OptionTable::tables(std::string_view key) const {
  const toml::node* node = state_->find(key);
  if (node == nullptr) return {};
  if (!node->is_array_of_tables()) fail_at(key, "expected an array of tables, found " + type_of(*node));
  auto& opened = state_->children[std::string(key)];
  if (opened.empty()) {
    for (const toml::node& entry : *node->as_array()) {
      opened.push_back(
          state_->child(entry.as_table(), fmt::format("{}[{}]", state_->key_path(key), opened.size() + 1)));
    }
  }
  std::vector<OptionTable> tables;
  for (const auto& state : opened) tables.push_back(OptionTable(state));
  return tables;
}

void OptionTable::leave(std::string_view key) const {
  state_->known.emplace(key);
}

std::string OptionTable::resolved_toml() const {
  return state_->resolved_toml();
}

void OptionTable::finish() const {
  state_->finish();
}

void OptionTable::fail_at(std::string_view key, std::string_view message) const {
  state_->fail_at(key, message);
}

const std::string& OptionTable::origin() const {
  return state_->origin;
}

std::filesystem::path OptionTable::resolved_path(std::string_view relative) const {
  return state_->folder / relative;
}

namespace detail {

void check_visited(const std::function<void(OptionVisitor&)>& show_options, std::string_view what) {
  Checker checker(what);
  show_options(checker);
}

std::string visited_as_toml(const std::function<void(OptionVisitor&)>& show_options) {
  Writer writer;
  show_options(writer);
  return writer.lines();
}

}  // namespace detail
}  // namespace knuckle
