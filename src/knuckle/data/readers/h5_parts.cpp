// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/h5_parts.h"

#include <algorithm>
#include <numeric>

#include <glob.h>

#include "knuckle/core/error.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

constexpr std::size_t kMostOpen = 64;

std::string text_of(const IndexRange& frames) {
  return frames.count == 1 ? fmt::format("frame {} is", frames.first)
                           : fmt::format("frames {} to {} are", frames.first, frames.end() - 1);
}

/// Which of the things that parts must share differs; empty where none does.
std::string difference(const H5Facts& first, const H5Facts& other) {
  if (other.manifest != first.manifest) return "was made from another manifest";
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

}  // namespace

H5Parts::H5Parts(const std::vector<fs::path>& paths) {
  if (paths.empty()) fail("no part of a set was given");
  std::vector<H5Facts> facts;
  for (const fs::path& path : paths) facts.push_back(H5Source(path).facts());
  std::vector<std::size_t> order(paths.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, [&](std::size_t part) { return facts[part].frames.first; });
  for (const std::size_t part : order) {
    paths_.push_back(paths[part]);
    facts_.push_back(std::move(facts[part]));
    check_alike(paths_.size() - 1);
    if (paths_.size() > 1) facts_.back().manifest.clear();  // the same again, for each of many parts
  }
  check_frames();
}

void H5Parts::check_alike(std::size_t part) const {
  const std::string found = difference(facts_.front(), facts_[part]);
  if (!found.empty()) {
    fail("{}: {} than {}; expected parts of one set", paths_[part].string(), found, paths_.front().string());
  }
}

/// That none is missing, and none is there twice.
void H5Parts::check_frames() const {
  const IndexRange first = facts_.front().frames;
  const IndexRange whole =
      facts_.front().part_of.value_or(IndexRange{first.first, facts_.back().frames.end() - first.first});
  std::int64_t next = whole.first;
  const auto require = [&](std::int64_t end, const fs::path& part, std::string_view side) {
    if (end > next) fail("{}: {} missing {} it", part.string(), text_of({next, end - next}), side);
  };
  for (std::size_t part = 0; part < facts_.size(); ++part) {
    const IndexRange frames = facts_[part].frames;
    require(frames.first, paths_[part], "before");
    if (frames.first < next) {
      const std::int64_t end = std::min(next, frames.end());
      fail("{}: {} in {}, too; expected parts of one set, each once", paths_[part].string(),
           text_of({frames.first, end - frames.first}), paths_[part - 1].string());
    }
    next = frames.end();
  }
  require(whole.end(), paths_.back(), "after");
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
