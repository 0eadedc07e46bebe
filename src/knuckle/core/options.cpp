// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/options.h"

#include <algorithm>
#include <map>
#include <set>

#include <toml++/toml.h>

#include "knuckle/core/limits.h"
#include "knuckle/core/option_reader.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/core/suggestion.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"

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

  [[noreturn]] void fail_at_unknown(std::string_view key) const {
    const std::vector<std::string> names(known.begin(), known.end());
    fail_at(key, fmt::format("unknown key{}; known are {}", suggestion(key, names), joined(names)));
  }

  /// For a key that is missing: throws where the table has one instead that looks like a slip for it.
  void require_not_mistyped(const std::string& key) const {
    if (table == nullptr) return;
    for (const auto& [found, node] : *table) {
      if (!known.contains(found.str()) && !suggestion(found.str(), std::span(&key, 1)).empty())
        fail_at_unknown(found.str());
    }
  }

  void finish() const {
    if (table != nullptr) {
      for (const auto& [key, node] : *table) {
        if (!known.contains(key.str())) fail_at_unknown(key.str());
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

OptionTable::OptionTable(std::shared_ptr<State> state) : state_(std::move(state)) {}

OptionTable OptionTable::load(const std::filesystem::path& path) {
  return parse(read_regular_file(path, limits::kDocumentBytes), path.string(), path.parent_path());
}

/// Where a comment or a string that begins at `place` ends; `place` itself where there is none.
std::size_t end_of_text(std::string_view toml, std::size_t place) {
  if (toml[place] == '#') return std::min(toml.find('\n', place), toml.size());
  if (toml[place] != '"' && toml[place] != '\'') return place;
  const std::string mark(1, toml[place]);
  const std::string triple = mark + mark + mark;
  const bool is_long = toml.substr(place).starts_with(triple);
  const std::string& end = is_long ? triple : mark;
  for (std::size_t i = place + end.size(); i < toml.size(); ++i) {
    if (toml[i] == '\\' && mark == "\"") {
      ++i;
    } else if (toml.substr(i).starts_with(end)) {
      return i + end.size();
    } else if (toml[i] == '\n' && !is_long) {
      return i;
    }
  }
  return toml.size();
}

/// Throws where so many tables or lists stand in one another that reading them could run out of stack: by the
/// brackets that are open, and the dots of a key.
void require_shallow(std::string_view toml, const std::string& origin) {
  int open = 0;
  int dots = 0;
  for (std::size_t i = 0; i < toml.size(); ++i) {
    const std::size_t end = end_of_text(toml, i);
    if (end > i) {
      i = end - 1;
      continue;
    }
    const char c = toml[i];
    if (c == '[' || c == '{') ++open;
    if ((c == ']' || c == '}') && open > 0) --open;
    const bool is_key_over = c == '\n' || c == '=' || c == ',' || c == '[' || c == ']';
    dots = is_key_over ? 0 : dots + (c == '.' ? 1 : 0);
    if (open > limits::kNesting || dots > limits::kNesting) {
      const auto line = 1 + std::ranges::count(toml.substr(0, i), '\n');
      fail("{}:{}: tables or lists stand in one another more than {} deep", origin, line, limits::kNesting);
    }
  }
}

OptionTable OptionTable::parse(std::string_view toml, const std::string& origin,
                               const std::filesystem::path& folder) {
  auto state = std::make_shared<State>();
  state->origin = origin;
  state->folder = folder;
  require_shallow(toml, origin);
  try {
    state->document = std::make_shared<const toml::table>(toml::parse(toml));
  } catch (const toml::parse_error& error) {
    fail("{}:{}: no valid TOML: {}", origin, error.source().begin.line, error.description());
  }
  state->table = state->document.get();
  return OptionTable(std::move(state));
}

void OptionTable::visit(const std::function<void(OptionVisitor&)>& show_options) const {
  OptionReader<State> reader(*state_);
  show_options(reader);
  const std::string lines = detail::visited_as_toml(show_options);
  // Read by two components; whole lines, since one may be the end of another.
  const bool is_repeated = ("\n" + state_->resolved).find("\n" + lines) != std::string::npos;
  if (!is_repeated) state_->resolved += lines;
}

bool OptionTable::has(std::string_view key) const {
  return state_->table != nullptr && state_->table->contains(key);
}

std::string OptionTable::required_text(std::string_view key) const {
  if (state_->find(key) == nullptr) {
    state_->require_not_mistyped(std::string(key));
    fail_at(key, "is missing, expected a text");
  }
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

}  // namespace knuckle
