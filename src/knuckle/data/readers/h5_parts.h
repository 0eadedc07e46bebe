// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/h5_source.h"

namespace knuckle {

/// Several files with parts of one Knuckle dataset, in the order of their frames. Few of them are open at a
/// time, however many there are. Safe to be used by many threads.
class H5Parts {
 public:
  /// Throws an Error that names all faults: files that are broken or unfinished, that were made from another
  /// manifest, by another program, or are of another size, unit or kind than most; that hold frames that
  /// another holds too; and which frames are missing, between them or, where the files say what they are
  /// parts of, at the ends.
  explicit H5Parts(const std::vector<std::filesystem::path>& paths);

  std::int64_t size() const;
  /// Of the whole: the frames of all parts; a part of nothing.
  H5Facts facts() const;
  /// The part that holds frame `index` in [0, size), and the frame's number in it. Throws as opening does
  /// where the file has changed since.
  std::pair<std::shared_ptr<const H5Source>, std::int64_t> part_of_frame(std::int64_t index) const;
  const std::vector<std::filesystem::path>& paths() const { return paths_; }

 private:
  std::shared_ptr<const H5Source> open(std::size_t part) const;

  std::vector<std::filesystem::path> paths_;  ///< in the order of their frames
  std::vector<H5Facts> facts_;                ///< of each; manifests of the first alone
  mutable std::mutex mutex_;                  ///< guards what follows
  mutable std::deque<std::pair<std::size_t, std::shared_ptr<const H5Source>>> open_;  ///< latest use first
};

/// The frames of `h5:parts/*.h5`: all parts as one set, without copying.
class H5PartsSource final : public FrameSource {
 public:
  /// Throws as H5Parts does.
  explicit H5PartsSource(const std::vector<std::filesystem::path>& paths) : parts_(paths) {}

  std::int64_t size() const override { return parts_.size(); }
  Frame read(std::int64_t index) const override;
  FrameLabel read_label(std::int64_t index) const override;
  std::optional<Convention> convention() const override;

 private:
  H5Parts parts_;
};

/// Throws an Error of one line with these faults, or as many as a person reads and how many more there are.
[[noreturn]] void fail_with_all(const std::vector<std::string>& faults);

/// Whether a path is a pattern of `*` or `[...]`, and no file's own name.
bool names_several_files(const std::filesystem::path& path);
/// The files that a path with `*`, `?` or `[...]` matches, sorted. Throws an Error where there is none.
std::vector<std::filesystem::path> matching_files(const std::filesystem::path& pattern);

}  // namespace knuckle
