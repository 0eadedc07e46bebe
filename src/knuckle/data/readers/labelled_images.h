// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/data/readers/line_index.h"

namespace knuckle {

/// PNG images named by the lines of an annotation file, `relative/image.png` and then numbers; without such a
/// file all PNG images below a folder.
class LabelledImages {
 public:
  /// `images` is the folder that names are relative to. Throws an Error where there is no image, or where the
  /// annotation file is missing.
  LabelledImages(std::filesystem::path images, const std::optional<std::filesystem::path>& annotation);

  std::int64_t size() const;
  bool has_labels() const { return lines_.has_value(); }

  /// One image with its label.
  struct Entry {
    std::string name;             ///< of the image, relative
    std::filesystem::path path;   ///< of the image
    std::vector<double> numbers;  ///< its label; empty where there are none
  };
  /// Image `index` with `number_count` numbers. Throws an Error that names file and line where these are not
  /// there.
  Entry read(std::int64_t index, std::size_t number_count) const;

 private:
  std::filesystem::path images_;
  std::optional<LineIndex> lines_;
  std::vector<std::string> names_;
};

/// The annotation file of a set: `chosen` in `folder` where it is given, else `usual` where that exists, else
/// none.
std::optional<std::filesystem::path> find_annotation(const std::filesystem::path& folder,
                                                     const std::string& chosen, const std::string& usual);

/// `folder/name` where that is a folder, otherwise `folder`.
std::filesystem::path subfolder_or_self(const std::filesystem::path& folder, const std::string& name);

}  // namespace knuckle
