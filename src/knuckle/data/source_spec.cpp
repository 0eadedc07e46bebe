// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/source_spec.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

#include "knuckle/core/suggestion.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

using Settings = std::vector<std::pair<std::string, std::string>>;

/// Sets options from the `key=value` texts of a source, and remembers which keys there are.
class SettingsReader final : public OptionVisitor {
 public:
  SettingsReader(const Settings& settings, std::string where)
      : settings_(settings), where_(std::move(where)) {}

  const std::vector<std::string>& known() const { return known_; }
  bool knows(const std::string& key) const { return std::ranges::find(known_, key) != known_.end(); }

  void real(std::string_view name, double& value, const Interval& range) override {
    if (const std::string* text = find(name)) value = in_range(name, parse_number(*text, at(name)), range);
  }
  void integer(std::string_view name, int& value, const Interval& range) override {
    if (const std::string* text = find(name)) {
      const long long number = parse_integer(*text, at(name));
      const double highest = std::min<double>(range.high, std::numeric_limits<int>::max());
      in_range(name, static_cast<double>(number), {range.low, highest, range.low_open, false});
      value = static_cast<int>(number);
    }
  }
  void seed(std::string_view name, std::uint64_t& value) override {
    if (const std::string* text = find(name)) {
      const long long number = parse_integer(*text, at(name));
      in_range(name, static_cast<double>(number), at_least(0));
      value = static_cast<std::uint64_t>(number);
    }
  }
  void flag(std::string_view name, bool& value) override {
    const std::string* text = find(name);
    if (!text) return;
    if (*text != "true" && *text != "false") fail("{}: '{}' is neither true nor false", at(name), *text);
    value = *text == "true";
  }
  void text(std::string_view name, std::string& value) override {
    if (const std::string* text = find(name)) value = *text;
  }
  void choice(std::string_view name, std::string& value, std::span<const std::string_view> known) override {
    const std::string* text = find(name);
    if (!text) return;
    if (std::ranges::find(known, *text) == known.end()) fail_unknown(name, *text, known);
    value = *text;
  }
  void reals(std::string_view name, std::vector<double>& value, const Interval& range, std::size_t shortest,
             std::size_t longest) override {
    const std::string* text = find(name);
    if (!text) return;
    std::vector<double> numbers = parse_numbers(*text, at(name));
    if (numbers.size() < shortest || numbers.size() > longest)
      fail("{}: has {} numbers, expected {} to {}", at(name), numbers.size(), shortest, longest);
    for (const double number : numbers) in_range(name, number, range);
    value = std::move(numbers);
  }
  void texts(std::string_view name, std::vector<std::string>& value,
             std::span<const std::string_view> known) override {
    const std::string* text = find(name);
    if (!text) return;
    value.clear();
    for (const std::string_view part : split(*text, ',')) {
      if (!known.empty() && std::ranges::find(known, part) == known.end()) fail_unknown(name, part, known);
      value.emplace_back(part);
    }
  }

 private:
  /// The value of a key, and a note that the key exists.
  const std::string* find(std::string_view name) {
    known_.emplace_back(name);
    for (const auto& [key, value] : settings_)
      if (key == name) return &value;
    return nullptr;
  }
  [[noreturn]] void fail_unknown(std::string_view name, std::string_view value,
                                 std::span<const std::string_view> known) const {
    fail("{}: '{}' is unknown{}; known are {}", at(name), value, suggestion(value, known),
         joined({known.begin(), known.end()}));
  }
  std::string at(std::string_view name) const { return fmt::format("{}: {}", where_, name); }
  double in_range(std::string_view name, double number, const Interval& range) const {
    if (!range.contains(number)) fail("{} = {} is not in {}", at(name), number, range.text());
    return number;
  }

  const Settings& settings_;
  std::string where_;
  std::vector<std::string> known_;
};

Settings parse_settings(std::string_view query, std::string_view whole) {
  Settings settings;
  for (const std::string_view part : split(query, '&')) {
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos || equals == 0)
      fail("source '{}': '{}' is not key=value", whole, part);
    std::string key(part.substr(0, equals));
    for (const auto& setting : settings)
      if (setting.first == key) fail("source '{}': the key '{}' appears twice", whole, key);
    settings.emplace_back(std::move(key), part.substr(equals + 1));
  }
  return settings;
}

}  // namespace

SourceSpec parse_source_spec(std::string_view text) {
  SourceSpec spec = parse_camera_spec(text);
  if (spec.path.empty()) fail("source '{}' names no path; expected KIND:PATH[?key=value&...]", text);
  return spec;
}

SourceSpec parse_camera_spec(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos || colon == 0)
    fail("source '{}' names no kind; expected KIND:PATH[?key=value&...]", text);
  std::string_view path = text.substr(colon + 1);
  SourceSpec spec{std::string(text), std::string(text.substr(0, colon)), {}, {}, {}};
  if (const std::size_t question = path.rfind('?'); question != std::string_view::npos) {
    spec.settings = parse_settings(path.substr(question + 1), text);
    path = path.substr(0, question);
  }
  spec.path = path;

  SettingsReader reader(spec.settings, fmt::format("source '{}'", text));
  spec.selection.visit(reader);
  std::erase_if(spec.settings, [&](const auto& setting) { return reader.knows(setting.first); });
  return spec;
}

void detail::read_settings(const SourceSpec& spec, const std::function<void(OptionVisitor&)>& show_options) {
  SettingsReader reader(spec.settings, fmt::format("source '{}'", spec.text));
  show_options(reader);
  for (const auto& setting : spec.settings) {
    if (reader.knows(setting.first)) continue;
    std::vector<std::string> known{"first", "count", "step"};
    known.insert(known.end(), reader.known().begin(), reader.known().end());
    fail("source '{}': unknown key '{}'{}; known are {}", spec.text, setting.first,
         suggestion(setting.first, known), joined(known));
  }
}

void require_no_settings(const SourceSpec& spec) {
  detail::read_settings(spec, [](OptionVisitor&) {});
}

}  // namespace knuckle
