// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/error.h"

namespace knuckle {

/// The values a number may take.
struct Interval {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;   ///< `low` itself is excluded
  bool high_open = false;  ///< `high` itself is excluded

  bool contains(double value) const;  ///< false for NaN
  std::string text() const;           ///< as in "(0, 500]"
};

/// [low, high].
inline Interval closed(double low, double high) {
  return {low, high, false, false};
}
/// (low, high].
inline Interval open_closed(double low, double high) {
  return {low, high, true, false};
}
/// [low, high).
inline Interval closed_open(double low, double high) {
  return {low, high, false, true};
}
/// (low, high).
inline Interval open_interval(double low, double high) {
  return {low, high, true, true};
}
/// [low, infinity).
inline Interval at_least(double low) {
  return {low, std::numeric_limits<double>::infinity(), false, true};
}
/// (low, infinity).
inline Interval above(double low) {
  return {low, std::numeric_limits<double>::infinity(), true, true};
}

/// Is shown every option of a component once, with its name and range. Reading, checking and writing options
/// are three visitors, so that a component declares each option in one place only:
///
///     struct MeanShiftOptions {
///       double bandwidth_mm = 13.5;  ///< Kernel bandwidth h, (0, 500] [mm]
///       void visit(OptionVisitor& visitor) { visitor.real("bandwidth_mm", bandwidth_mm, open_closed(0,
///       500)); }
///     };
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;
  virtual void real(std::string_view name, double& value, const Interval& range) = 0;
  virtual void integer(std::string_view name, int& value, const Interval& range) = 0;
  virtual void seed(std::string_view name, std::uint64_t& value) = 0;
  virtual void flag(std::string_view name, bool& value) = 0;
  virtual void text(std::string_view name, std::string& value) = 0;
  /// A text that must be one of `known`.
  virtual void choice(std::string_view name, std::string& value, std::span<const std::string_view> known) = 0;
  /// A list of numbers, each in `range`; its length must lie in [shortest, longest].
  virtual void reals(std::string_view name, std::vector<double>& value, const Interval& range,
                     std::size_t shortest, std::size_t longest) = 0;
  /// A list of texts, each one of `known`; any text where `known` is empty.
  virtual void texts(std::string_view name, std::vector<std::string>& value,
                     std::span<const std::string_view> known) = 0;
};

template <class T>
concept VisitableOptions = requires(T options, OptionVisitor& visitor) {
  options.visit(visitor);
};

/// A table of a TOML file, read strictly: every key must be known, of the right type and in range. Errors
/// name the file, line and key. Cheap to copy; copies share the record of what was read.
class OptionTable {
 public:
  /// Throws an Error that names the file (and line) where it is missing or no TOML.
  static OptionTable load(const std::filesystem::path& path);
  /// `origin` stands for the file's name in messages; relative paths start from `folder`, by default that of
  /// the process.
  static OptionTable parse(std::string_view toml, const std::string& origin,
                           const std::filesystem::path& folder = {});

  /// Sets the options that the table has a key for; the others keep their values.
  template <VisitableOptions Options>
  void read(Options& options) const {
    visit([&](OptionVisitor& visitor) { options.visit(visitor); });
  }

  /// Whether the table has that key. Does not count as reading it.
  bool has(std::string_view key) const;
  /// The text under `key`. Throws where it is missing or no text.
  std::string required_text(std::string_view key) const;
  /// The text under `key`, or `otherwise`.
  std::string text_or(std::string_view key, std::string_view otherwise) const;
  /// The text under `key` must be one of `known`; `otherwise` where it is missing.
  std::string choice_or(std::string_view key, std::string_view otherwise,
                        std::span<const std::string_view> known) const;
  /// The table under `key`; an empty one where it is missing.
  OptionTable table(std::string_view key) const;
  /// The tables of an array of tables under `key`; none where it is missing.
  std::vector<OptionTable> tables(std::string_view key) const;

  /// Counts `key` as read, whatever stands under it: it belongs to somebody else.
  void leave(std::string_view key) const;

  /// Throws where a key of this table, or of a table taken from it, was not read, and lists those that are
  /// known. Call it last; once on the whole document is enough.
  void finish() const;

  /// What was read so far, defaults included, as TOML: this table and those taken from it.
  std::string resolved_toml() const;

  /// Throws an Error that names the file, the line of `key`, the key, and `message`.
  [[noreturn]] void fail_at(std::string_view key, std::string_view message) const;

  /// The name of the file (or what stands for it), and the folder that its relative paths start from.
  const std::string& origin() const;
  std::filesystem::path resolved_path(std::string_view relative) const;

 private:
  struct State;
  explicit OptionTable(std::shared_ptr<State> state);
  void visit(const std::function<void(OptionVisitor&)>& show_options) const;

  std::shared_ptr<State> state_;
};

/// Throws an Error that starts with `what` and names the first option out of its range.
template <VisitableOptions Options>
void check_options(Options options, std::string_view what);

/// The options as lines of TOML, `key = value`.
template <VisitableOptions Options>
std::string options_as_toml(Options options);

namespace detail {
void check_visited(const std::function<void(OptionVisitor&)>& show_options, std::string_view what);
std::string visited_as_toml(const std::function<void(OptionVisitor&)>& show_options);
}  // namespace detail

template <VisitableOptions Options>
void check_options(Options options, std::string_view what) {
  detail::check_visited([&](OptionVisitor& visitor) { options.visit(visitor); }, what);
}

template <VisitableOptions Options>
std::string options_as_toml(Options options) {
  return detail::visited_as_toml([&](OptionVisitor& visitor) { options.visit(visitor); });
}

}  // namespace knuckle
