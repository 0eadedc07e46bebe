// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace knuckle {

/// A text file that grows by one piece per record.
struct GrowingFile {
  std::filesystem::path path;  ///< its final name; until it is whole it is called `path` + ".partial"
  std::string head;            ///< what stands before the first record
};

/// What the content of growing files depends on (inputs, options, version), by name; one line each.
using RunIdentity = std::vector<std::pair<std::string, std::string>>;

/// Text files that grow together, record by record, on the disk as they come, and get their final names when
/// all are whole. A run that was killed at any moment goes on: a journal beside them says after each record
/// how long every file was, so that all are cut back to the same whole records. The journal also keeps a note
/// of each record, for what is written in the end. Not safe to call from several threads at once.
///
/// Errors name the file; what was written stays for a later run, whatever happens.
class GrowingFiles {
 public:
  enum class Begin {
    anew,             ///< what an earlier run left is replaced
    where_it_stopped  ///< goes on from what an earlier run left; begins anew where there is nothing
  };

  /// `journal` is where the journal lies. Throws an Error where a file cannot be written, where another
  /// process is writing it, and where a run goes on that was begun with another identity: it names what
  /// differs.
  GrowingFiles(std::filesystem::path journal, std::vector<GrowingFile> files, const RunIdentity& identity,
               Begin begin);
  ~GrowingFiles();
  GrowingFiles(const GrowingFiles&) = delete;
  GrowingFiles& operator=(const GrowingFiles&) = delete;

  /// Records in the files, from earlier runs too.
  std::int64_t size() const { return size_; }

  /// Adds a record: a piece of each file, in their order, and a note of one line. Throws an Error also where
  /// a file has vanished meanwhile.
  void append(std::span<const std::string> pieces, std::string_view note);
  /// Calls `visit` with the notes of all records, in order.
  void for_each_note(const std::function<void(std::string_view note)>& visit) const;

  /// Hands all files to the disk and gives them their final names; the journal goes last. A run that is
  /// killed here goes on as well.
  void publish();

 private:
  struct OpenFile {
    std::filesystem::path path;
    std::filesystem::path partial;
    std::string head;
    int descriptor = -1;
    std::uint64_t end = 0;  ///< where the next piece goes
  };

  void open_journal();
  void close_all();
  void begin_anew(const std::string& head);
  void write_heads(const std::string& journal_head);
  bool restore(const std::string& head);
  void restore_records(std::uint64_t journal_head);
  void require_published() const;
  void require_in_place(const OpenFile& file) const;
  std::string ends_line(std::string_view note) const;

  OpenFile journal_;
  std::vector<OpenFile> files_;
  std::int64_t size_ = 0;
  bool is_whole_ = false;  ///< all records are there, some files may have their final names
};

/// `path` + ".partial".
std::filesystem::path partial_path(const std::filesystem::path& path);

}  // namespace knuckle
