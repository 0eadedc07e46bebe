// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/growing_files.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <fstream>
#include <optional>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/open_own_file.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

constexpr std::string_view kJournalFormat = "knuckle run 1\n";
constexpr std::string_view kEndOfIdentity = "---\n";
constexpr std::string_view kWhole = "whole";  // the journal's last line: every record is there

[[noreturn]] void fail_to_write(const fs::path& path, int code) {
  fail("{}: cannot write: {}", path.string(), std::generic_category().message(code));
}

void write_piece(int descriptor, std::uint64_t offset, std::string_view text, const fs::path& named) {
  while (!text.empty()) {
    const ssize_t written = ::pwrite(descriptor, text.data(), text.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail_to_write(named, written < 0 ? errno : ENOSPC);
    offset += static_cast<std::uint64_t>(written);
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void cut(int descriptor, std::uint64_t size, const fs::path& named) {
  if (::ftruncate(descriptor, static_cast<off_t>(size)) != 0) fail_to_write(named, errno);
}

void sync(int descriptor, const fs::path& named) {
  if (::fsync(descriptor) != 0) fail_to_write(named, errno);
}

std::uint64_t size_of(int descriptor) {
  struct stat state {};
  return ::fstat(descriptor, &state) == 0 ? static_cast<std::uint64_t>(state.st_size) : 0;
}

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

std::string head_of(const RunIdentity& identity) {
  std::string head(kJournalFormat);
  for (const auto& [name, value] : identity) head += fmt::format("{}: {}\n", name, one_line(value));
  return head + std::string(kEndOfIdentity);
}

/// The lines of a journal's head, without their ends; empty where it was cut short.
std::vector<std::string> head_lines(std::string_view text) {
  const std::size_t end = text.find(kEndOfIdentity);
  if (!text.starts_with(kJournalFormat) || end == std::string_view::npos) return {};
  std::vector<std::string> lines;
  for (const std::string_view line : split(text.substr(0, end), '\n')) lines.emplace_back(line);
  return lines;
}

std::string name_in(std::string_view line) {
  return std::string(line.substr(0, line.find(": ")));
}

std::string value_in(std::string_view line) {
  const std::size_t colon = line.find(": ");
  return colon == std::string_view::npos ? std::string() : std::string(line.substr(colon + 2));
}

/// Throws where a run was begun with another identity.
void require_same(const std::vector<std::string>& found, const std::vector<std::string>& expected,
                  const fs::path& journal) {
  for (std::size_t i = 0; i < std::max(found.size(), expected.size()); ++i) {
    const std::string was = i < found.size() ? found[i] : std::string();
    const std::string is = i < expected.size() ? expected[i] : std::string();
    if (was == is) continue;
    fail(
        "{}: the run was begun with another {}: '{}', now it is '{}'; go on with what it was begun with, or "
        "begin again without --resume",
        journal.string(), name_in(is.empty() ? was : is), value_in(was), value_in(is));
  }
}

/// Where the files ended after a record, and its note.
struct JournalLine {
  std::vector<std::uint64_t> ends;
  std::string_view note;
};

std::optional<JournalLine> parse_line(std::string_view line, std::size_t files) {
  JournalLine parsed;
  for (std::size_t i = 0; i < files; ++i) {
    const std::size_t blank = line.find(' ');
    if (blank == std::string_view::npos) return std::nullopt;
    std::uint64_t end = 0;
    const auto [rest, fault] = std::from_chars(line.data(), line.data() + blank, end);
    if (fault != std::errc() || rest != line.data() + blank) return std::nullopt;
    parsed.ends.push_back(end);
    line.remove_prefix(blank + 1);
  }
  parsed.note = line;
  return parsed;
}

}  // namespace

fs::path partial_path(const fs::path& path) {
  return path.string() + ".partial";
}

GrowingFiles::GrowingFiles(fs::path journal, std::vector<GrowingFile> files, const RunIdentity& identity,
                           Begin begin) {
  journal_.path = journal_.partial = std::move(journal);
  for (GrowingFile& file : files) {
    files_.push_back({file.path, partial_path(file.path), std::move(file.head)});
  }
  try {
    open_journal();
    const std::string head = head_of(identity);
    if (begin == Begin::where_it_stopped && restore(head)) return;
    begin_anew(head);
  } catch (...) {
    close_all();
    throw;
  }
}

GrowingFiles::~GrowingFiles() {
  close_all();
}

void GrowingFiles::close_all() {
  for (OpenFile& file : files_) {
    if (file.descriptor >= 0) ::close(file.descriptor);
    file.descriptor = -1;
  }
  if (journal_.descriptor >= 0) ::close(journal_.descriptor);
  journal_.descriptor = -1;
}

void GrowingFiles::open_journal() {
  journal_.descriptor = open_own_file_alone(journal_.path, O_CREAT, "another run is writing it");
}

void GrowingFiles::begin_anew(const std::string& head) {
  size_ = 0;
  cut(journal_.descriptor, 0, journal_.path);
  try {
    write_heads(head);
  } catch (...) {
    std::error_code ignored;
    for (const OpenFile& file : files_) fs::remove(file.partial, ignored);
    fs::remove(journal_.path, ignored);
    throw;
  }
}

void GrowingFiles::write_heads(const std::string& journal_head) {
  for (OpenFile& file : files_) {
    if (file.descriptor < 0) file.descriptor = open_own_file(file.partial, O_CREAT);
    if (file.descriptor < 0) fail_to_write(file.partial, errno);
    cut(file.descriptor, 0, file.partial);
    write_piece(file.descriptor, 0, file.head, file.partial);
    file.end = file.head.size();
  }
  write_piece(journal_.descriptor, 0, journal_head, journal_.path);
  journal_.end = journal_head.size();
}

/// False where there is nothing to go on from.
bool GrowingFiles::restore(const std::string& head) {
  std::ifstream stream(journal_.path, std::ios::binary);
  std::string begun(64 * 1024, '\0');
  stream.read(begun.data(), static_cast<std::streamsize>(begun.size()));
  begun.resize(static_cast<std::size_t>(stream.gcount()));
  const std::vector<std::string> found = head_lines(begun);
  if (found.empty()) return false;
  require_same(found, head_lines(head), journal_.path);
  for (OpenFile& file : files_) {
    file.end = file.head.size();
    file.descriptor = open_own_file(file.partial, 0);
    if (file.descriptor < 0 && errno != ENOENT) fail_to_write(file.partial, errno);
  }
  restore_records(head.size());
  if (is_whole_) return true;
  const auto is_too_short = [](const OpenFile& file) {
    return file.descriptor < 0 || size_of(file.descriptor) < file.end;
  };
  if (std::ranges::any_of(files_, is_too_short)) return false;
  for (const OpenFile& file : files_) cut(file.descriptor, file.end, file.partial);
  cut(journal_.descriptor, journal_.end, journal_.path);
  return true;
}

/// Takes in the records that are whole in all files.
void GrowingFiles::restore_records(std::uint64_t journal_head) {
  const bool was_whole = [&] {
    const std::string last = fmt::format("{}\n", kWhole);
    const std::uint64_t size = size_of(journal_.descriptor);
    std::string tail(std::min<std::uint64_t>(size, last.size()), '\0');
    const auto offset = static_cast<off_t>(size - tail.size());
    return ::pread(journal_.descriptor, tail.data(), tail.size(), offset) ==
               static_cast<ssize_t>(tail.size()) &&
           tail == last;
  }();
  std::vector<std::uint64_t> sizes;
  for (const OpenFile& file : files_) sizes.push_back(file.descriptor < 0 ? 0 : size_of(file.descriptor));

  std::ifstream stream(journal_.path, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(journal_head));
  journal_.end = journal_head;
  for (std::string line; std::getline(stream, line) && !stream.eof();) {
    if (was_whole && line == kWhole) break;
    const std::optional<JournalLine> parsed = parse_line(line, files_.size());
    if (!parsed) break;
    const bool is_there = was_whole || std::ranges::equal(parsed->ends, sizes, std::ranges::less_equal{});
    if (!is_there) break;
    for (std::size_t i = 0; i < files_.size(); ++i) files_[i].end = parsed->ends[i];
    journal_.end += line.size() + 1;
    ++size_;
  }
  is_whole_ = was_whole;
  if (is_whole_) require_published();
}

/// Of a run that was stopped while it gave names: each file has either of its two.
void GrowingFiles::require_published() const {
  for (const OpenFile& file : files_) {
    const fs::path& there = file.descriptor >= 0 ? file.partial : file.path;
    std::error_code missing;
    if (fs::file_size(there, missing) == file.end && !missing) continue;
    fail("{}: is missing or was changed after the run that wrote it; begin again without --resume",
         there.string());
  }
}

void GrowingFiles::require_in_place(const OpenFile& file) const {
  struct stat ours {};
  struct stat theirs {};
  const bool is_ours = ::fstat(file.descriptor, &ours) == 0 && ::stat(file.partial.c_str(), &theirs) == 0 &&
                       ours.st_ino == theirs.st_ino && ours.st_dev == theirs.st_dev;
  if (!is_ours) fail("{}: cannot write: it vanished while it was written", file.partial.string());
}

std::string GrowingFiles::ends_line(std::string_view note) const {
  std::string line;
  for (const OpenFile& file : files_) line += fmt::format("{} ", file.end);
  return fmt::format("{}{}\n", line, note);
}

void GrowingFiles::append(std::span<const std::string> pieces, std::string_view note) {
  if (is_whole_ || pieces.size() != files_.size() || note.find('\n') != std::string_view::npos) {
    fail("{}: expected one piece per file and a note of one line, before the files are published",
         journal_.path.string());
  }
  for (std::size_t i = 0; i < files_.size(); ++i) {
    OpenFile& file = files_[i];
    require_in_place(file);
    write_piece(file.descriptor, file.end, pieces[i], file.partial);
    file.end += pieces[i].size();
  }
  require_in_place(journal_);
  const std::string line = ends_line(note);
  write_piece(journal_.descriptor, journal_.end, line, journal_.path);
  journal_.end += line.size();
  ++size_;
}

void GrowingFiles::for_each_note(const std::function<void(std::string_view)>& visit) const {
  std::ifstream stream(journal_.path, std::ios::binary);
  std::string line;
  while (std::getline(stream, line) && line + "\n" != kEndOfIdentity) {
  }
  std::int64_t seen = 0;
  for (; seen < size_ && std::getline(stream, line); ++seen) {
    const std::optional<JournalLine> parsed = parse_line(line, files_.size());
    if (!parsed) break;
    visit(parsed->note);
  }
  if (seen != size_) fail("{}: cannot be read back", journal_.path.string());
}

void GrowingFiles::publish() {
  if (!is_whole_) {
    for (const OpenFile& file : files_) {
      require_in_place(file);
      sync(file.descriptor, file.partial);
    }
    write_piece(journal_.descriptor, journal_.end, fmt::format("{}\n", kWhole), journal_.path);
    sync(journal_.descriptor, journal_.path);
    is_whole_ = true;
  }
  for (const OpenFile& file : files_) {
    if (file.descriptor < 0 || !fs::exists(file.partial)) continue;  // an earlier run came as far
    std::error_code fault;
    fs::rename(file.partial, file.path, fault);
    if (fault) fail("{}: cannot write: {}", file.path.string(), fault.message());
    sync_folder_of(file.path);
  }
  std::error_code fault;
  fs::remove(journal_.path, fault);
  if (fault) fail("{}: cannot be removed: {}", journal_.path.string(), fault.message());
}

}  // namespace knuckle
