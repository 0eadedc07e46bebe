// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>

#include "knuckle/data/readers/timeline.h"
#include "knuckle/data/writers/frame_ledger.h"
#include "knuckle/data/writers/frame_writer.h"

namespace knuckle {

/// Writes the set that FolderSource reads. Images are named by their index; joints.txt, times.txt,
/// sequences.txt and dataset.toml come in the end. Poses wait in memory until then, about 1 KB a frame: the
/// format is for small sets.
class FolderWriter final : public FrameWriter {
 public:
  FolderWriter(std::filesystem::path folder, const FrameWriterOptions& options);

  void write(std::int64_t index, const Frame& frame) override;
  void finish() override;

 private:
  /// What is known of a frame besides its images.
  struct Kept {
    std::optional<HandPose> truth;
    std::optional<HandSide> side;
    std::optional<double> time_s;
    int sequence = 0;
  };

  void keep(std::int64_t index, const Frame& frame);
  Timeline timeline() const;
  std::string side() const;
  std::string joints_as_text() const;

  std::filesystem::path folder_;
  FrameWriterOptions options_;
  FrameLedger ledger_;
  std::mutex mutex_;
  std::optional<Convention> convention_;
  std::map<std::int64_t, Kept> frames_;
};

}  // namespace knuckle
