// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/labelled_images.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/file_listing.h"
#include "knuckle/data/truth.h"

namespace fs = std::filesystem;

namespace knuckle {

namespace {

/// Throws where a name leads out of the folder of the images, as far as its text says.
void require_inside(const std::string& name, const std::string& where) {
  constexpr std::size_t kShown = 200;
  const fs::path path(name);
  const bool climbs = std::ranges::any_of(path, [](const fs::path& part) { return part == ".."; });
  if (climbs || path.is_absolute() || name.find('\0') != std::string::npos) {
    fail("{}: names '{}', which does not lie in the folder of the images", where,
         printable(shortened(name, kShown)));
  }
}

}  // namespace

LabelledImages::LabelledImages(fs::path images, const std::optional<fs::path>& annotation)
    : images_(std::move(images)) {
  require_folder(images_);
  if (annotation) {
    lines_.emplace(*annotation);
    if (lines_->size() == 0) fail("{}: is empty", annotation->string());
  } else {
    names_ = list_files_below(images_, ".png");
    if (names_.empty()) fail("{}: holds no .png file", images_.string());
  }
}

std::int64_t LabelledImages::size() const {
  return lines_ ? lines_->size() : static_cast<std::int64_t>(names_.size());
}

LabelledImages::Entry LabelledImages::read(std::int64_t index, std::size_t number_count) const {
  if (!lines_) {
    const std::string& name = names_.at(static_cast<std::size_t>(index));
    return {name, images_ / name, {}};
  }
  const std::string line = lines_->line(index);
  const std::size_t name_start = line.find_first_not_of(" \t");
  const std::size_t name_end = std::min(line.find_first_of(" \t", name_start), line.size());
  const std::string name = line.substr(name_start, name_end - name_start);
  if (!name.ends_with(".png")) {
    fail("{}: starts with '{}', expected the name of a .png", lines_->where(index),
         printable(shortened(name, 80)));
  }
  require_inside(name, lines_->where(index));
  return {name, images_ / name,
          parse_annotation(std::string_view(line).substr(name_end), number_count, lines_->where(index))};
}

std::optional<fs::path> find_annotation(const fs::path& folder, const std::string& chosen,
                                        const std::string& usual) {
  require_folder(folder);
  if (!chosen.empty()) return folder / chosen;
  if (fs::exists(folder / usual)) return folder / usual;
  return std::nullopt;
}

fs::path subfolder_or_self(const fs::path& folder, const std::string& name) {
  return fs::is_directory(folder / name) ? folder / name : folder;
}

}  // namespace knuckle
