// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/h5_parts.h"

#include <algorithm>

#include <glob.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

constexpr std::size_t kMostOpen = 64;

std::string text_of(const IndexRange& frames) {
  return frames.count == 1 ? fmt::format("frame {} is", frames.first)
                           : fmt::format("frames {} to {} are", frames.first, frames.end() - 1);
}

std::string program_of(const H5Facts& facts) {
  return facts.generator.empty() ? "a program that does not say its version" : facts.generator;
}

/// Which of the things that parts must share differs; empty where none does.
std::string difference(const H5Facts& first, const H5Facts& other) {
  if (other.manifest != first.manifest) return "was made from another manifest";
  if (other.generator != first.generator) {
    return fmt::format("was made by another program ({}, not {})", program_of(other), program_of(first));
  }
  if (other.part_of != first.part_of) return "is a part of another set";
  if (other.depth_unit_mm != first.depth_unit_mm) return "has another unit of depth";
  if (other.camera.width != first.camera.width || other.camera.height != first.camera.height ||
      other.camera.model != first.camera.model || other.camera.distortion != first.camera.distortion) {
    return "has another size or kind of camera";
  }
  if (other.has_infrared != first.has_infrared || other.has_mask != first.has_mask ||
      other.has_labels != first.has_labels || other.has_time != first.has_time) {
    return "has other kinds of images or times";
  }
  return "";
}

/// A part that could be opened.
struct Part {
  fs::path path;
  H5Facts facts;     ///< without the manifest, which is the same in each of many parts
  std::size_t kind;  ///< its number in a PartList
};

/// Parts in the making of one set, and what is wrong with them.
class PartList {
 public:
  void open(const fs::path& path) {
    try {
      H5Facts facts = H5Source(path).facts();
      const std::size_t kind = kind_of(path, facts);
      facts.manifest.clear();
      parts_.push_back({path, std::move(facts), kind});
    } catch (const Error& error) {
      faults_.emplace_back(error.what());
    }
  }

  /// Those that fit together, in the order of their frames. Throws where any is wrong, twice there or
  /// missing.
  std::vector<Part> ordered() {
    if (!kinds_.empty()) {
      leave_out_foreign();
      std::ranges::stable_sort(parts_, {}, [](const Part& part) { return part.facts.frames.first; });
      note_missing_and_double();
    }
    if (!faults_.empty()) fail_with_all(faults_);
    parts_.front().facts.manifest = kinds_[parts_.front().kind].facts.manifest;
    return std::move(parts_);
  }

 private:
  /// Parts of one set.
  struct Kind {
    fs::path path;  ///< the first of them
    H5Facts facts;
    std::int64_t count = 0;
  };

  std::size_t kind_of(const fs::path& path, const H5Facts& facts) {
    auto kind = std::ranges::find_if(
        kinds_, [&](const Kind& known) { return difference(known.facts, facts).empty(); });
    if (kind == kinds_.end()) kind = kinds_.insert(kind, {path, facts});
    ++kind->count;
    return static_cast<std::size_t>(kind - kinds_.begin());
  }

  /// What most are is the set; the first kind, where several are as many.
  void leave_out_foreign() {
    const auto set = std::ranges::max_element(kinds_, {}, &Kind::count);
    const auto number = static_cast<std::size_t>(set - kinds_.begin());
    for (const Part& part : parts_) {
      if (part.kind == number) continue;
      faults_.push_back(fmt::format("{}: {} than {}; expected parts of one set", part.path.string(),
                                    difference(set->facts, kinds_[part.kind].facts), set->path.string()));
    }
    std::erase_if(parts_, [&](const Part& part) { return part.kind != number; });
  }

  void note_missing_and_double() {
    const IndexRange first = parts_.front().facts.frames;
    const IndexRange whole = parts_.front().facts.part_of.value_or(
        IndexRange{first.first, parts_.back().facts.frames.end() - first.first});
    std::int64_t next = whole.first;
    const auto note_missing = [&](std::int64_t end, const fs::path& part, std::string_view side) {
      if (end <= next) return;
      faults_.push_back(
          fmt::format("{}: {} missing {} it", part.string(), text_of({next, end - next}), side));
    };
    const Part* last = nullptr;  // of those so far, the one that reaches farthest
    for (const Part& part : parts_) {
      const IndexRange frames = part.facts.frames;
      note_missing(frames.first, part.path, "before");
      if (last != nullptr && frames.first < next) {
        const std::int64_t end = std::min(next, frames.end());
        faults_.push_back(fmt::format("{}: {} in {}, too; expected parts of one set, each once",
                                      part.path.string(), text_of({frames.first, end - frames.first}),
                                      last->path.string()));
      }
      if (last == nullptr || frames.end() > next) last = &part;
      next = std::max(next, frames.end());
    }
    note_missing(whole.end(), last->path, "after");
  }

  std::vector<Part> parts_;
  std::vector<Kind> kinds_;
  std::vector<std::string> faults_;
};

}  // namespace

void fail_with_all(const std::vector<std::string>& faults) {
  constexpr std::size_t kMostNamed = 20;
  const auto named = static_cast<std::ptrdiff_t>(std::min(faults.size(), kMostNamed));
  std::string line = joined({faults.begin(), faults.begin() + named}, "; ");
  if (faults.size() > kMostNamed) line += fmt::format("; ... and {} more", faults.size() - kMostNamed);
  throw Error(line);
}

H5Parts::H5Parts(const std::vector<fs::path>& paths) {
  if (paths.empty()) fail("no part of a set was given");
  PartList list;
  for (const fs::path& path : paths) list.open(path);
  for (Part& part : list.ordered()) {
    paths_.push_back(std::move(part.path));
    facts_.push_back(std::move(part.facts));
  }
}

std::int64_t H5Parts::size() const {
  return facts_.back().frames.end() - facts_.front().frames.first;
}

H5Facts H5Parts::facts() const {
  H5Facts facts = facts_.front();
  facts.frames.count = size();
  facts.part_of.reset();
  return facts;
}

std::shared_ptr<const H5Source> H5Parts::open(std::size_t part) const {
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find(open_, part, [](const auto& entry) { return entry.first; });
  if (found != open_.end()) {
    std::rotate(open_.begin(), found, found + 1);
    return open_.front().second;
  }
  auto source = std::make_shared<const H5Source>(paths_[part]);
  if (source->size() != facts_[part].frames.count)
    fail("{}: was changed while it was read", paths_[part].string());
  open_.emplace_front(part, source);
  if (open_.size() > kMostOpen) open_.pop_back();
  return source;
}

std::pair<std::shared_ptr<const H5Source>, std::int64_t> H5Parts::part_of_frame(std::int64_t index) const {
  if (index < 0 || index >= size())
    fail("{} and others: have {} frames, asked for frame {}", paths_.front().string(), size(), index);
  const std::int64_t number = facts_.front().frames.first + index;
  const auto after =
      std::ranges::upper_bound(facts_, number, {}, [](const H5Facts& part) { return part.frames.first; });
  const auto part = static_cast<std::size_t>(after - facts_.begin()) - 1;
  return {open(part), number - facts_[part].frames.first};
}

Frame H5PartsSource::read(std::int64_t index) const {
  const auto [part, frame] = parts_.part_of_frame(index);
  return part->read(frame);
}

FrameLabel H5PartsSource::read_label(std::int64_t index) const {
  const auto [part, frame] = parts_.part_of_frame(index);
  return part->read_label(frame);
}

std::optional<Convention> H5PartsSource::convention() const {
  return parts_.part_of_frame(0).first->convention();
}

bool names_several_files(const fs::path& path) {
  return path.string().find_first_of("*[") != std::string::npos && !fs::exists(path);
}

std::vector<fs::path> matching_files(const fs::path& pattern) {
  glob_t found{};
  const int fault = ::glob(pattern.c_str(), 0, nullptr, &found);
  std::vector<fs::path> paths(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  ::globfree(&found);
  if (fault != 0 || paths.empty()) fail("{}: no file is named so", pattern.string());
  return paths;
}

}  // namespace knuckle
