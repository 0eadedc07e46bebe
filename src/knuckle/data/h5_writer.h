// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <mutex>
#include <optional>
#include <vector>

#include "knuckle/core/hdf5_file.h"
#include "knuckle/data/frame_ledger.h"
#include "knuckle/data/frame_writer.h"

namespace knuckle {

/// Writes the file that H5Source reads, as `F.h5.partial` until `finish` renames it. Now and then all that
/// was written goes to the disk, and only then are its frames marked in `written`; a later run with the same
/// options keeps them. A remainder that cannot be read is begun anew.
class H5Writer final : public FrameWriter {
 public:
  H5Writer(std::filesystem::path path, const FrameWriterOptions& options);
  ~H5Writer() override;

  void write(std::int64_t index, const Frame& frame) override;
  bool has(std::int64_t index) const override { return ledger_.has(index); }
  void finish() override;

 private:
  void resume();
  void require_same_run(const Hdf5File& file) const;
  void create(const FrameLayout& layout);
  void write_rows(std::uint64_t row, const Frame& frame);
  void mark_pending();

  std::filesystem::path path_;
  std::filesystem::path partial_;
  FrameWriterOptions options_;
  FrameLedger ledger_;
  std::mutex mutex_;  ///< guards what follows
  std::optional<Hdf5File> file_;
  std::vector<std::int64_t> pending_;  ///< frames in the file that are not marked yet
};

}  // namespace knuckle
