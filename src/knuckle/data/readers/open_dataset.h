// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "knuckle/data/frame_source.h"
#include "knuckle/data/source_spec.h"

namespace knuckle {

/// A kind of data set on disk.
struct DatasetKind {
  std::string_view name;         ///< as written before the colon of a source
  std::string_view description;  ///< one line for a person
  std::unique_ptr<FrameSource> (*open)(
      const SourceSpec&);  ///< opens all frames; the selection is not its matter
};

/// All kinds of this module: folder, icg, icvl, nyu, msra15, hands17, h5, fakenect, rosbag, mcap. Layers
/// above may know more.
std::span<const DatasetKind> dataset_kinds();

/// Opens the frames of that kind that `spec` selects.
std::unique_ptr<FrameSource> open_frames(const DatasetKind& kind, const SourceSpec& spec);

/// Opens the frames that `spec` selects. Throws an Error that lists the kinds where it is none of them, and
/// whatever the reader finds wrong.
std::unique_ptr<FrameSource> open_dataset(const SourceSpec& spec);

/// The same from the source as written.
std::unique_ptr<FrameSource> open_dataset(std::string_view text);

}  // namespace knuckle
