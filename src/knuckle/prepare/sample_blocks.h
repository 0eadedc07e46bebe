// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "knuckle/prepare/inputs.h"
#include "knuckle/prepare/sample_block_index.h"
#include "knuckle/prepare/sample_cutter.h"
#include "knuckle/prepare/sample_stream.h"

namespace knuckle {

/// Samples in a folder, for sets that are larger than memory: `block_000000.h5` and so on, each the samples
/// of 1,024 frames that follow one another as `write_samples` writes them, and `index.h5` when all are there.
class SampleBlocks final : public SampleStream {
 public:
  /// Frames of a block; the last has what is left.
  static constexpr std::int64_t kFrames = 1024;

  /// Where the folder's samples come from.
  struct Making {
    Inputs inputs;  ///< all that they depend on
    SampleOptions options;
    std::string what;  ///< names the work, as in "samples"
    std::function<std::unique_ptr<SampleCutter>()> cutter;
  };

  /// Opens the folder. Blocks that are missing are made, one after another: they take the memory of one, and
  /// an interrupted making goes on with the next. Throws an Error that names the file where one cannot be
  /// written, is damaged or of other inputs.
  static std::unique_ptr<SampleBlocks> opened(const std::filesystem::path& folder, const Making& making);

  std::int64_t size() const override { return first_.back(); }
  const std::vector<std::int64_t>& runs() const override { return runs_; }
  const SampleFrames& frames() const override { return frames_; }
  const std::vector<bool>& known_joints() const override { return known_; }
  CubeSamples room_for(std::int64_t count) const override { return room_for_samples(count, options_); }
  /// Reads each block once. Throws an Error that names the file where one is missing, damaged or has changed.
  void fetch(std::span<const std::int64_t> numbers, CubeSamples& to, std::int64_t first) const override;

 private:
  SampleBlocks(std::filesystem::path folder, Making making, const std::vector<SampleBlockNote>& blocks);

  std::filesystem::path folder_;
  Inputs inputs_;
  SampleOptions options_;
  std::vector<std::int64_t> runs_;
  std::vector<std::int64_t> first_;  ///< number of each block's first sample; then of all
  SampleFrames frames_;
  std::vector<bool> known_;
};

}  // namespace knuckle
