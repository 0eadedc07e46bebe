// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/data/readers/file_stream.h"
#include "knuckle/data/readers/recording_file.h"

namespace knuckle {

/// An array of doubles in a Matlab file of version 5 (MathWorks, "MAT-File Format", level 5), little-endian,
/// packed or not. Read as a stream, so it takes no memory of its size. For one thread.
class MatlabArray {
 public:
  /// Finds the array of this name. Throws an Error that names the file where it is no such file, is cut short
  /// or damaged, has no such array, or where that is not one of real doubles, or of more than the file can
  /// hold.
  MatlabArray(const std::filesystem::path& path, std::string_view name);
  MatlabArray(const MatlabArray&) = delete;
  MatlabArray& operator=(const MatlabArray&) = delete;
  ~MatlabArray() = default;

  /// Lengths along its two or more axes.
  const std::vector<std::int64_t>& shape() const { return shape_; }
  /// The next values in Matlab's order: the first axis runs fastest. Throws where there are not so many, or
  /// the file is damaged.
  void read(std::span<double> values);
  /// Throws unless all values were read and the sum of a packed array fits.
  void require_end();

 private:
  struct Tag;

  void require_version_5() const;
  /// Goes through all elements of the file, and stays at the first that is the array.
  void find(std::string_view name);
  Tag read_tag();
  /// Reads what stands before an array's values; false where it is another array.
  bool read_head(std::string_view name);
  /// `most_bytes`: what the array's part of the file can hold.
  void find_values(std::string_view name, std::uint64_t most_bytes);

  RecordingFile file_;
  FileStream stream_;
  std::uint64_t element_end_ = 0;  ///< in the stream
  std::uint32_t flags_ = 0;
  std::vector<std::int64_t> shape_;
  std::uint32_t type_ =
      0;  ///< of the values as stored: Matlab stores doubles as integers where they are some
  std::uint64_t left_ = 0;  ///< values that were not yet read
};

}  // namespace knuckle
