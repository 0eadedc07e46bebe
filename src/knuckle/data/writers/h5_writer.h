// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "knuckle/data/readers/frame_log.h"
#include "knuckle/data/readers/stored_frame.h"
#include "knuckle/data/writers/frame_ledger.h"
#include "knuckle/data/writers/frame_writer.h"
#include "knuckle/data/writers/h5_assembly.h"

namespace knuckle {

/// Writes the file that H5Source reads. Frames are compressed by the threads that bring them and wait in a
/// log, `F.h5.partial`, in the order in which they come; `finish` puts them in their own order into the HDF5
/// file. So a kill at any moment costs no frame that was written, a later run with the same options goes on
/// from there, and the file has the same bytes whatever the threads and interruptions. For the time of
/// `finish` the frames take twice their room on the disk.
class H5Writer final : public FrameWriter {
 public:
  H5Writer(std::filesystem::path path, const FrameWriterOptions& options);

  void write(std::int64_t index, const Frame& frame) override;
  bool has(std::int64_t index) const override { return ledger_.has(index); }
  void finish() override;
  /// Frames that are written, by earlier runs too.
  std::int64_t size() const { return ledger_.size(); }

 private:
  void restore();
  StoredFrame logged(std::int64_t index) const;
  std::int64_t count() const;
  H5Facts facts() const;

  std::filesystem::path path_;
  FrameWriterOptions options_;
  FrameLedger ledger_;
  FrameLog log_;
};

}  // namespace knuckle
