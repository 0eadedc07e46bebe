// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "knuckle/data/readers/frame_log.h"
#include "knuckle/data/readers/stored_frame.h"
#include "knuckle/data/readers/timeline.h"
#include "knuckle/data/writers/frame_ledger.h"
#include "knuckle/data/writers/frame_writer.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

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
  std::int64_t count() const;
  void write_whole(const std::filesystem::path& path) const;
  void create_arrays(Hdf5Writer& file) const;
  /// Frames [first, first + count) of the set, from the log.
  std::vector<StoredFrame> read_back(std::int64_t first, std::int64_t count) const;
  void write_frames(Hdf5Writer& file) const;
  void write_timeline(Hdf5Writer& file, const Timeline& timeline) const;

  std::filesystem::path path_;
  FrameWriterOptions options_;
  FrameLedger ledger_;
  FrameLog log_;
};

/// The camera of the first frame as attributes of the file.
void write_camera(Hdf5Writer& file, const Camera& camera);

}  // namespace knuckle
