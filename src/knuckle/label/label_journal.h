// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/label/label_book.h"

namespace knuckle {

/// What to do where labels were made of a source that has changed since.
enum class ChangedSource { refuse, accept };

/// The file labels.jsonl of one author while labels change: lines are only ever added, each is on the disk
/// before it counts as written, and a last line that a kill has cut is taken away at the next start.
///
/// Where a line cannot be written (the disk is full, the folder has become read-only), it waits in memory,
/// with all that come after it: `fault` says why, and each `flush` tries again. Used by one thread at a time.
class LabelJournal {
 public:
  /// Opens the file, or begins it; folders above it are made. Throws an Error that names it where it cannot
  /// be written, another process writes it, a line in it is wrong (with its number), or it belongs to another
  /// source: another number of frames or convention; another fingerprint, unless `changed` accepts it, and
  /// then the new head is added.
  LabelJournal(std::filesystem::path path, const LabelHead& head,
               ChangedSource changed = ChangedSource::refuse);
  /// Tries once more to write what waits.
  ~LabelJournal();
  LabelJournal(const LabelJournal&) = delete;
  LabelJournal& operator=(const LabelJournal&) = delete;

  const LabelBook& book() const { return *book_; }
  const std::filesystem::path& path() const { return path_; }

  /// Adds changes to the book and to the file. Throws an Error where one does not fit the book; what the disk
  /// does is in `fault`.
  void add(LabelChange change);
  /// As `add`, for many at once: one wait for the disk.
  void add_all(std::vector<LabelChange> changes);

  /// Tries to write what waits. Whether nothing waits any more.
  bool flush();
  /// Lines that are not on the disk yet.
  std::size_t waiting() const { return waiting_.size(); }
  /// Why they are not, in a line; empty where none waits.
  const std::string& fault() const { return fault_; }

 private:
  void read_or_begin(const LabelHead& head, ChangedSource changed);
  void require_same_source(const LabelHead& head, ChangedSource changed);
  void write_line(const std::string& line);
  void write_waiting();

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t end_ = 0;  ///< of the last line that is on the disk
  std::optional<LabelBook> book_;
  std::deque<std::string> waiting_;
  std::string fault_;
};

/// DIR/labels.jsonl; of a named author DIR/labels.AUTHOR.jsonl. Throws an Error where the name is none
/// (`is_author_name`).
std::filesystem::path label_file(const std::filesystem::path& folder, const std::string& author);

/// The labels.*.jsonl in a folder, sorted by name. Throws an Error where there is none.
std::vector<std::filesystem::path> label_files(const std::filesystem::path& folder);

/// Reads a labels.jsonl as it stands, also while it is being written. Throws an Error that names file and
/// line.
LabelBook read_label_file(const std::filesystem::path& path);

}  // namespace knuckle
