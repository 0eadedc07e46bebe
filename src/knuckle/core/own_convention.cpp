// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/own_convention.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <mutex>
#include <set>
#include <shared_mutex>
#include <string>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/options.h"

namespace knuckle {
namespace {

struct OwnLandmark {
  std::string name;
  Landmark near;
};

struct OwnConvention {
  std::string name;
  std::vector<Landmark> landmarks;
  Convention convention;  ///< of the two above
};

/// What was named so far. Rows keep their place in memory.
struct Registry {
  std::shared_mutex mutex;
  std::deque<OwnLandmark> landmarks;
  std::deque<OwnConvention> conventions;

  static Registry& get() {
    static Registry registry;
    return registry;
  }
  const OwnLandmark& row_of(Landmark landmark) {
    const std::shared_lock lock(mutex);
    return landmarks.at(static_cast<std::size_t>(landmark) - kKnownLandmarks);
  }
};

void check_name(std::string_view name, std::string_view what) {
  constexpr std::size_t kLongest = 64;
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto may_follow = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; };
  if (name.empty() || name.size() > kLongest || !is_letter(name[0]) ||
      !std::ranges::all_of(name, may_follow)) {
    fail(
        "'{}' cannot name a {}: expected a small letter, then small letters, digits and underscores, at most "
        "{}",
        name, what, kLongest);
  }
}

void check_landmarks(std::string_view name, const std::vector<Landmark>& landmarks) {
  if (landmarks.empty()) fail("the convention '{}' has no landmark", name);
  if (landmarks.size() > static_cast<std::size_t>(limits::kJoints)) {
    fail("the convention '{}' has {} landmarks, expected at most {}", name, landmarks.size(),
         limits::kJoints);
  }
  std::set<Landmark> seen;
  for (const Landmark landmark : landmarks) {
    if (!seen.insert(landmark).second)
      fail("the convention '{}' has the landmark '{}' twice", name, name_of(landmark));
  }
}

/// The part of a definition's file that names things. Where they lie is of no matter here.
struct NamedLandmarks {
  std::string convention;
  std::vector<std::string> landmarks;

  void visit(OptionVisitor& visitor) {
    visitor.text("convention", convention);
    visitor.texts("landmarks", landmarks, {});
  }
};

/// The landmark of the 22 that a table of the file tells one from.
Landmark told_from(const OptionTable& document, const std::string& name) {
  if (!document.has(name)) {
    document.fail_at("landmarks", "names '" + name + "', which is no landmark of ours: expected a table [" +
                                      name + "] that says from which `bone` it is told");
  }
  const OptionTable table = document.table(name);
  const std::optional<Landmark> bone = known_landmark(table.required_text("bone"));
  if (!bone || static_cast<int>(*bone) >= kSupersetSize)
    table.fail_at("bone", "is none of the 22 landmarks of knuckle22");
  return *bone;
}

constexpr std::string_view kDefinitionEnd = ".toml";
constexpr char kNear = '~';  ///< between a landmark of one's own and that which it lies near to

/// As in "index_tip", or "glove_knob~index_mcp".
Landmark landmark_from_text(std::string_view text) {
  const std::size_t mark = text.find(kNear);
  const std::string_view name = text.substr(0, mark);
  const std::optional<Landmark> known = known_landmark(name);
  if (mark == std::string_view::npos) {
    if (!known)
      fail("'{}' is no landmark; expected one of ours, or NAME{}LANDMARK of one's own", name, kNear);
    return *known;
  }
  const std::optional<Landmark> near = known_landmark(text.substr(mark + 1));
  if (known || !near || static_cast<int>(*near) >= kSupersetSize)
    fail("'{}' is no landmark of one's own: expected a new name, {}, and one of the 22", text, kNear);
  return own_landmark(name, *near);
}

const Convention* find_registered(std::string_view name) {
  Registry& registry = Registry::get();
  const std::shared_lock lock(registry.mutex);
  const auto found = std::ranges::find(registry.conventions, name, &OwnConvention::name);
  return found == registry.conventions.end() ? nullptr : &found->convention;
}

}  // namespace

bool is_own(Landmark landmark) {
  return static_cast<std::size_t>(landmark) >= kKnownLandmarks;
}

std::optional<Landmark> known_landmark(std::string_view name) {
  for (std::size_t i = 0; i < kKnownLandmarks; ++i) {
    const auto landmark = static_cast<Landmark>(i);
    if (name_of(landmark) == name) return landmark;
  }
  return std::nullopt;
}

Landmark own_landmark(std::string_view name, Landmark near) {
  if (const std::optional<Landmark> known = known_landmark(name)) return *known;
  check_name(name, "landmark");
  Registry& registry = Registry::get();
  const std::unique_lock lock(registry.mutex);
  const auto found = std::ranges::find(registry.landmarks, name, &OwnLandmark::name);
  const std::size_t place = kKnownLandmarks + static_cast<std::size_t>(found - registry.landmarks.begin());
  if (place > std::numeric_limits<std::underlying_type_t<Landmark>>::max())
    fail("landmark '{}': there are too many landmarks", name);
  if (found == registry.landmarks.end()) registry.landmarks.push_back({std::string(name), near});
  return static_cast<Landmark>(place);
}

std::string_view own_landmark_name(Landmark landmark) {
  return Registry::get().row_of(landmark).name;
}

Landmark own_landmark_is_near(Landmark landmark) {
  return Registry::get().row_of(landmark).near;
}

const Convention& register_convention(std::string_view name, const std::vector<Landmark>& landmarks) {
  check_name(name, "convention");
  check_landmarks(name, landmarks);
  if (std::ranges::find(conventions(), name, &Convention::name) != conventions().end())
    fail("the convention '{}' is one that every data set knows; expected another name", name);
  Registry& registry = Registry::get();
  const std::unique_lock lock(registry.mutex);
  const auto found = std::ranges::find(registry.conventions, name, &OwnConvention::name);
  if (found != registry.conventions.end()) {
    if (found->landmarks != landmarks)
      fail("the convention '{}' was told before with other landmarks; expected another name", name);
    return found->convention;
  }
  OwnConvention& made = registry.conventions.emplace_back(OwnConvention{std::string(name), landmarks, {}});
  made.convention = {made.name, made.landmarks};
  return made.convention;
}

const Convention& registered_convention(std::string_view name) {
  const Convention* const found = find_registered(name);
  if (found == nullptr) fail("unknown convention '{}'", name);
  return *found;
}

std::vector<Convention> own_conventions() {
  Registry& registry = Registry::get();
  const std::shared_lock lock(registry.mutex);
  std::vector<Convention> all;
  for (const OwnConvention& own : registry.conventions) all.push_back(own.convention);
  return all;
}

const Convention& convention_from_file(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  NamedLandmarks named;
  document.read(named);
  if (!document.has("convention"))
    fail("{}: lacks 'convention', the name of what it defines", document.origin());
  if (!document.has("landmarks")) return convention_from_name(named.convention);
  std::vector<Landmark> landmarks;
  for (const std::string& name : named.landmarks) {
    const std::optional<Landmark> known = known_landmark(name);
    try {
      landmarks.push_back(known ? *known : own_landmark(name, told_from(document, name)));
    } catch (const Error& error) {
      if (std::string_view(error.what()).starts_with(document.origin())) throw;
      document.fail_at("landmarks", error.what());
    }
  }
  try {
    return register_convention(named.convention, landmarks);
  } catch (const Error& error) {
    document.fail_at("convention", error.what());
  }
}

std::string convention_text(const Convention& convention) {
  const bool is_everybodys =
      std::ranges::find(conventions(), convention.name, &Convention::name) != conventions().end();
  std::string text(convention.name);
  if (is_everybodys) return text;
  const char* before = ": ";
  for (const Landmark landmark : convention.landmarks) {
    text += before;
    text += name_of(landmark);
    if (is_own(landmark)) text += fmt::format("{}{}", kNear, name_of(own_landmark_is_near(landmark)));
    before = ", ";
  }
  return text;
}

const Convention& convention_from_text(std::string_view text) {
  const std::size_t end = text.find(": ");
  if (end == std::string_view::npos) return convention_from_name(text);
  std::vector<Landmark> landmarks;
  std::string_view rest = text.substr(end + 2);
  while (landmarks.size() <= static_cast<std::size_t>(limits::kJoints)) {
    const std::size_t comma = std::min(rest.find(", "), rest.size());
    landmarks.push_back(landmark_from_text(rest.substr(0, comma)));
    if (comma == rest.size()) break;
    rest.remove_prefix(comma + 2);
  }
  return register_convention(text.substr(0, end), landmarks);
}

const Convention& convention_from_option(const std::string& text) {
  return text.ends_with(kDefinitionEnd) ? convention_from_file(text) : convention_from_name(text);
}

const Convention& convention_from_key(const OptionTable& document, std::string_view key,
                                      std::string_view otherwise) {
  const std::string text = document.text_or(key, otherwise);
  if (text.ends_with(kDefinitionEnd)) return convention_from_file(document.resolved_path(text));
  try {
    return convention_from_name(text);
  } catch (const Error& error) {
    document.fail_at(key, error.what());
  }
}

const Convention& convention_in_folder(const std::string& text, const std::filesystem::path& folder) {
  if (!text.ends_with(kDefinitionEnd)) return convention_from_name(text);
  const std::filesystem::path file(text);
  if (file != file.filename()) fail("is \"{}\"; expected the name of a file in the same folder", text);
  return convention_from_file(folder / file);
}

}  // namespace knuckle
