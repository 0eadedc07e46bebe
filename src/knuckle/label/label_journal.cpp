// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_journal.h"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/open_own_file.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

constexpr std::string_view kBegins = "labels";
constexpr std::string_view kEnds = ".jsonl";
constexpr const char* kInUse = "another program writes these labels; end it, or work as another --author";

[[noreturn]] void fail_to_write(const fs::path& path, int code) {
  fail("{}: cannot write: {}", path.string(), std::generic_category().message(code));
}

}  // namespace

LabelJournal::LabelJournal(fs::path path, const LabelHead& head, ChangedSource changed)
    : path_(std::move(path)) {
  if (path_.has_parent_path()) make_folder(path_.parent_path());
  descriptor_ = open_own_file_alone(path_, O_CREAT, kInUse);
  try {
    read_or_begin(head, changed);
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

LabelJournal::~LabelJournal() {
  flush();
  ::close(descriptor_);
}

void LabelJournal::read_or_begin(const LabelHead& head, ChangedSource changed) {
  auto read = read_labels(read_regular_file(path_, limits::kTextFileBytes), path_.string());
  end_ = read ? read->whole_bytes : 0;
  if (::ftruncate(descriptor_, static_cast<off_t>(end_)) != 0) fail_to_write(path_, errno);
  if (read) {
    book_.emplace(std::move(read->book));
    return require_same_source(head, changed);
  }
  book_.emplace(head);
  write_line(to_json_line(head) + "\n");
  sync_folder_of(path_);
}

void LabelJournal::require_same_source(const LabelHead& head, ChangedSource changed) {
  const LabelHead& found = book_->head();
  if (found.frames != head.frames) {
    fail("{}: labels of {} with {} frames; {} has {}: choose another folder for its labels", path_.string(),
         found.source, found.frames, head.source, head.frames);
  }
  if (!(found.convention == head.convention)) {
    fail("{}: labels in the convention {}, not {}; go on with --convention {}, or choose another folder",
         path_.string(), found.convention.name, head.convention.name, found.convention.name);
  }
  if (found.fingerprint == head.fingerprint && found.camera == head.camera) return;
  if (changed == ChangedSource::refuse) {
    fail(
        "{}: the frames of {} have changed since these labels of {} were made; where they are the same to a "
        "person's eye, go on with --accept-changed-source",
        path_.string(), head.source, found.source);
  }
  book_->take_head(head, path_.string());
  write_line(to_json_line(head) + "\n");
}

void LabelJournal::add(LabelChange change) {
  std::vector<LabelChange> one;
  one.push_back(std::move(change));
  add_all(std::move(one));
}

void LabelJournal::add_all(std::vector<LabelChange> changes) {
  for (LabelChange& change : changes) {
    change = rounded(std::move(change));
    std::string line = to_json_line(change, book_->head().convention) + "\n";
    book_->add(std::move(change));
    waiting_.push_back(std::move(line));
  }
  flush();
}

bool LabelJournal::flush() {
  try {
    write_waiting();
    fault_.clear();
  } catch (const Error& error) {
    fault_ = error.what();
  }
  return waiting_.empty();
}

/// All that waits in one piece; where that fails, nothing of it.
void LabelJournal::write_waiting() {
  if (waiting_.empty()) return;
  if (::access(path_.c_str(), W_OK) != 0) fail_to_write(path_, errno);  // taken away, or made read-only
  std::string piece;
  for (const std::string& line : waiting_) piece += line;
  write_line(piece);
  waiting_.clear();
}

void LabelJournal::write_line(const std::string& line) {
  std::size_t written = 0;
  int code = 0;
  while (written < line.size()) {
    const ssize_t count = ::pwrite(descriptor_, line.data() + written, line.size() - written,
                                   static_cast<off_t>(end_ + written));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      code = count < 0 ? errno : ENOSPC;
      break;
    }
    written += static_cast<std::size_t>(count);
  }
  if (code == 0 && ::fsync(descriptor_) != 0) code = errno;
  if (code != 0) {
    (void)!::ftruncate(descriptor_, static_cast<off_t>(end_));  // a torn line is cut at the next start, too
    fail_to_write(path_, code);
  }
  end_ += line.size();
}

fs::path label_file(const fs::path& folder, const std::string& author) {
  if (author.empty()) return folder / "labels.jsonl";
  if (!is_author_name(author))
    fail("author '{}': expected 1 to 64 letters, digits, '_', '-' and '.', and no '.' first", author);
  return folder / fmt::format("{}.{}{}", kBegins, author, kEnds);
}

std::vector<fs::path> label_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code fault;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, fault)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("labels.") && name.ends_with(kEnds)) files.push_back(entry.path());
  }
  if (fault) fail("{}: cannot be read: {}", folder.string(), fault.message());
  if (files.empty()) fail("{}: holds no labels: there is no labels.jsonl in it", folder.string());
  std::ranges::sort(files);
  return files;
}

LabelBook read_label_file(const fs::path& path) {
  auto read = read_labels(read_regular_file(path, limits::kTextFileBytes), path.string());
  if (!read) fail("{}: holds no labels: it has not one whole line", path.string());
  return std::move(read->book);
}

}  // namespace knuckle
