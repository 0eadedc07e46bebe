// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>

#include "knuckle/prepare/inputs.h"
#include "knuckle/prepare/network_samples.h"
#include "knuckle/storage/hdf5/hdf5_file.h"

namespace knuckle {

/// Writes training samples as an HDF5 file, "knuckle-samples" version 1, atomically: `codes` N x crop x crop
/// (deflated), `joints` N x J x 3, `centres_mm` N x 3 as CubeSample has them, `sums` N (XXH3 of all of a
/// sample and its number), and the attributes `patch` (size [px], side [mm]), `frames` (total, without a
/// hand, off centre) and `inputs` (their hash). Throws an Error that names the file where it cannot be
/// written.
void write_samples(const std::filesystem::path& path, const NetworkSamples& samples, const Inputs& inputs);

/// Reads what `write_samples` wrote. Throws an Error that names the file where it is damaged, foreign or of
/// other inputs.
NetworkSamples read_samples(const std::filesystem::path& path, const Inputs& inputs);

/// A file of `write_samples`, some samples of which are read. Errors name the file.
class SampleFile {
 public:
  /// Throws as `read_samples` does, before any codes are read.
  SampleFile(const std::filesystem::path& path, const Inputs& inputs);

  std::int64_t size() const { return static_cast<std::int64_t>(count_); }
  const SampleFrames& frames() const { return frames_; }
  /// Whether `read` can tell samples that are damaged in any way; files of older versions have no sums.
  bool has_sums() const { return !sums_.empty(); }
  /// Samples of the file's sizes.
  CubeSamples room_for(std::int64_t count) const;
  bool has_sizes_of(const CubeSamples& samples) const;
  CubeSamples read() const;
  /// Reads samples `numbers`, each in [0, size), to the places from `first` on of `to`, which has the sizes.
  /// Throws where a sum is wrong.
  void read(std::span<const std::int64_t> numbers, CubeSamples& to, std::int64_t first) const;

 private:
  [[noreturn]] void damaged(std::string_view why) const;
  void read_frames();
  void check_numbers() const;
  std::uint64_t pixels() const { return static_cast<std::uint64_t>(crop_px_) * crop_px_; }
  CubeSample sample(std::uint64_t index, std::span<const std::uint8_t> codes) const;
  void check_sum(std::uint64_t index, const CubeSample& sample) const;

  Hdf5File file_;
  Hdf5Array<float> joints_;
  Hdf5Array<double> centres_;
  std::vector<std::uint64_t> sums_;  ///< empty in files that were written before there were sums
  std::uint64_t count_ = 0;
  int crop_px_ = 0;
  Cube patch_;
  SampleFrames frames_;
};

}  // namespace knuckle
