// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace knuckle {

// A model's file is a zip (storage/zip_archive.h) of
// - `model.json`: {"format": "knuckle-...", "version": N, "values": {NAME: text, number or list of texts},
//   "arrays": {NAME: {"type": "float32", "shape": [rows, columns]}}};
// - an entry NAME for each array: its numbers row by row, little-endian; where its description says
//   "shuffled": true, the first bytes of all numbers, then the second bytes of all, ...;
// and its comment is "knuckle-sum " and 16 hexadecimal digits: CRC-32 and Adler-32 of all bytes before them.
// A file of which any byte was changed is so refused.

/// An array of a model: its shape (slowest dimension first) and its numbers, row-major.
template <class T>
struct ModelArray {
  std::vector<std::uint64_t> shape;
  std::vector<T> values;
};

/// Gathers a model's values and arrays, and writes them as one file. Where a name was given before, it is
/// replaced. T is one of float, double, std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t,
/// std::uint32_t, std::int64_t, std::uint64_t.
class ModelWriter {
 public:
  ModelWriter(std::string_view format, int version);

  void set(std::string_view name, std::string_view text);
  void set(std::string_view name, double number);
  void set(std::string_view name, const std::vector<std::string>& texts);
  /// How an array lies in the file: shuffled and deflated, or as it is.
  enum class Storage { compact, plain };
  /// `values` has as many numbers as the shape says.
  template <class T>
  void add(std::string_view name, const std::vector<std::uint64_t>& shape, std::span<const T> values,
           Storage storage = Storage::compact);
  template <class T>
  void add(std::string_view name, const std::vector<std::uint64_t>& shape, const std::vector<T>& values) {
    add(name, shape, std::span<const T>(values));
  }
  /// As if it had never been set or added.
  void remove(std::string_view name);
  /// Another format or version than it was made with.
  void set_format(std::string_view format, int version);

  /// A hash of the content (storage/content_hash.h).
  std::string content_hash() const;
  /// The file's bytes: the same content makes the same.
  std::vector<std::uint8_t> bytes() const;
  /// Writes the file, atomically. Throws an Error that names it where it cannot be written.
  void save(const std::filesystem::path& path) const;

 private:
  friend class ModelFile;
  using Value = std::variant<std::string, double, std::vector<std::string>>;
  struct Array {
    std::string type;
    std::vector<std::uint64_t> shape;
    std::vector<std::uint8_t> bytes;
    Storage storage = Storage::compact;
    bool is_shuffled() const;
  };

  std::string header() const;

  std::string format_;
  int version_;
  std::map<std::string, Value, std::less<>> values_;
  std::map<std::string, Array, std::less<>> arrays_;
};

/// Reads a model's file. All faults are Errors of one line that name the file. Its sum, its structure and all
/// sizes are checked as it is opened, before an array takes memory; what its numbers mean is the reader's to
/// check. Safe to read from several threads.
class ModelFile {
 public:
  /// Throws an Error where it is missing, cut short, damaged, foreign, or of Knuckle 0.1.
  static ModelFile open(const std::filesystem::path& path);
  /// The same of bytes in memory; `origin` stands for the file's name.
  static ModelFile parse(std::string bytes, const std::string& origin);

  ModelFile(ModelFile&&) noexcept;
  ModelFile& operator=(ModelFile&&) noexcept;
  ~ModelFile();

  /// The file's name, for messages.
  const std::string& origin() const;
  const std::string& format() const;

  /// Throws unless it is of this format and version.
  void require_format(std::string_view format, int version) const;

  bool has(std::string_view name) const;
  std::string text(std::string_view name) const;
  double number(std::string_view name) const;
  /// A whole number within [lowest, highest]. Throws where it is none.
  int integer(std::string_view name, int lowest, int highest) const;
  std::vector<std::string> texts(std::string_view name) const;
  const std::vector<std::uint64_t>& shape(std::string_view name) const;
  /// Throws also where the array holds another type of numbers than T.
  template <class T>
  ModelArray<T> read(std::string_view name) const;

  /// Its content, to write it again with changes.
  ModelWriter writer() const;

 private:
  struct Content;
  explicit ModelFile(std::unique_ptr<Content> content);
  std::unique_ptr<Content> content_;
};

}  // namespace knuckle
