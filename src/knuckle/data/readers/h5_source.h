// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "knuckle/camera/projection.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/h5_facts.h"
#include "knuckle/data/readers/stored_frame.h"
#include "knuckle/data/readers/timeline.h"
#include "knuckle/storage/hdf5/hdf5_file.h"

namespace knuckle {

/// The Knuckle dataset, one HDF5 file (h5_format.h says what is in it). Reads one frame's rows at a time, and
/// compares their sums: damage, and a file that is cut short or replaced meanwhile, is an Error of the frame
/// that is read.
class H5Source final : public FrameSource {
 public:
  /// Throws an Error that names the file where it is missing, cut short, no Knuckle dataset, of an unknown
  /// version, unfinished, empty, or where its arrays do not fit together.
  explicit H5Source(const std::filesystem::path& path);

  std::int64_t size() const override { return size_; }
  Frame read(std::int64_t index) const override;
  FrameLabel read_label(std::int64_t index) const override;
  std::optional<Convention> convention() const override;

  H5Facts facts() const;
  /// Frame `index` in [0, size) as it stands in the file, its images compressed anew. Throws as `read` does.
  StoredFrame read_stored(std::int64_t index) const;

 private:
  void require_shape(std::string_view array, const std::vector<std::uint64_t>& expected) const;
  Timeline read_timeline() const;
  void require_unchanged() const;
  H5Facts facts_of_all() const;
  std::uint64_t row_of(std::int64_t index) const;
  std::string name_of(std::int64_t index) const;
  Camera read_frame_camera(std::uint64_t row) const;
  StoredFrame read_numbers(std::uint64_t row) const;
  std::vector<StoredHand> read_stored_hands(std::uint64_t row) const;
  StoredImages read_images(std::uint64_t row) const;
  template <class T>
  Image<T> read_image(std::string_view array, std::uint64_t row) const;
  Image<std::uint8_t> read_labels(std::uint64_t row) const;
  void check_sums(std::uint64_t row, const StoredFrame& numbers, const StoredImages* images) const;
  FrameLabel label_of(std::uint64_t row, const StoredFrame& numbers) const;
  std::vector<HandTruth> hands_of(std::uint64_t row, const StoredFrame& numbers) const;
  void read_hands_ends();

  Hdf5File file_;
  std::uintmax_t bytes_;  ///< of the file as it was opened
  Camera camera_;         ///< of the first frame
  double depth_unit_mm_;
  std::int64_t first_index_;
  std::int64_t size_;
  bool has_infrared_;
  bool has_mask_;
  bool has_joints_;
  bool has_intrinsics_;
  bool has_side_;
  bool has_labels_;
  bool has_sums_;
  std::uint64_t facts_sum_ = 0;           ///< where it has sums
  std::vector<std::int64_t> hands_ends_;  ///< of each frame; empty where hands are not known
  Timeline timeline_;
};

/// Reads all frames of a Knuckle dataset, on all cores, and returns what it says of itself. Throws an Error
/// as H5Source does where something in it is not what was written.
H5Facts check_h5(const std::filesystem::path& path);

}  // namespace knuckle
