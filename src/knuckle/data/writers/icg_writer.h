// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/data/writers/frame_ledger.h"
#include "knuckle/data/writers/frame_writer.h"

namespace knuckle {

/// Writes the synthetic form of the set that IcgSource reads: depth as EXR in metres, the mask as red pixels,
/// infrared as CSV, labels by the annotator `blender`; the calibration comes in the end. What lies beyond the
/// reader's background distance, or below its smallest infrared, is in the files but is no measurement to the
/// reader.
class IcgWriter final : public FrameWriter {
 public:
  IcgWriter(std::filesystem::path folder, const FrameWriterOptions& options);

  void write(std::int64_t index, const Frame& frame) override;
  void finish() override;

 private:
  std::filesystem::path folder_;
  FrameLedger ledger_;
};

}  // namespace knuckle
