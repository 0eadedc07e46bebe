// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/folder_format.h"
#include "knuckle/data/readers/line_index.h"
#include "knuckle/data/readers/timeline.h"

namespace knuckle {

/// Knuckle's interchange format for small sets: a folder with `dataset.toml`, `depth/*.png` (16 bits, sorted
/// by name), and optionally `infrared/` (8 or 16 bits), `mask/` (not 0 = hand), both with the names of depth,
/// `joints.txt` (one line per frame, J x `u v d` in px, px, mm, `nan` where unknown), `times.txt` and
/// `sequences.txt` (timeline.h).
class FolderSource final : public FrameSource {
 public:
  explicit FolderSource(std::filesystem::path folder);

  std::int64_t size() const override { return static_cast<std::int64_t>(names_.size()); }
  Frame read(std::int64_t index) const override;
  FrameLabel read_label(std::int64_t index) const override;
  std::optional<Convention> convention() const override;
  PixelOrigin pixel_origin() const override { return description_.pixel_origin; }

 private:
  std::optional<HandPose> read_truth(std::int64_t index) const;

  std::filesystem::path folder_;
  FolderDescription description_;
  std::vector<std::string> names_;  ///< of the files in depth/
  Timeline timeline_;
  std::optional<LineIndex> joints_;
  bool has_infrared_ = false;
  bool has_mask_ = false;
};

}  // namespace knuckle
