// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/line_index.h"

namespace knuckle {

/// The MSRA 2015 hand set (Sun et al. 2015), 320x240: a folder per subject, in it one per gesture, in it
/// `NNNNNN_depth.bin` (a cropped image) and `joint.txt` (the number of frames, then 63 numbers per frame).
/// The path may be the set, a subject or a gesture; each gesture is a sequence. A gesture without joint.txt
/// gives frames without truth.
class Msra15Source final : public FrameSource {
 public:
  explicit Msra15Source(std::filesystem::path folder);

  std::int64_t size() const override { return static_cast<std::int64_t>(entries_.size()); }
  Frame read(std::int64_t index) const override;
  FrameLabel read_label(std::int64_t index) const override;
  std::optional<Convention> convention() const override;

 private:
  struct Gesture {
    std::string folder;               ///< relative to the path, with '/' at its end, or empty
    std::optional<LineIndex> joints;  ///< joint.txt: the count first, then a line per frame
  };
  struct Entry {
    std::size_t gesture;
    std::string name;  ///< of the file
  };

  void add(const std::string& path);
  std::string name_of(const Entry& entry) const;
  std::optional<HandPose> read_truth(const Gesture& gesture, const std::string& name) const;

  std::filesystem::path folder_;
  std::vector<Gesture> gestures_;
  std::vector<Entry> entries_;
  Projection projection_;
};

/// Reads one `NNNNNN_depth.bin`: six uint32 (width, height of the image; left, top, right, bottom of the box,
/// the last two exclusive), then the box's depths as float32 in mm, little-endian. Outside the box nothing
/// was measured.
Image<float> read_msra15_depth(const std::filesystem::path& path);

}  // namespace knuckle
