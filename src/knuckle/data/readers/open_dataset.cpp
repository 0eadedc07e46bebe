// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/open_dataset.h"

#include <array>
#include <string_view>

#include "knuckle/core/named_table.h"
#include "knuckle/data/readers/fakenect_source.h"
#include "knuckle/data/readers/folder_source.h"
#include "knuckle/data/readers/h5_parts.h"
#include "knuckle/data/readers/h5_source.h"
#include "knuckle/data/readers/hands17_source.h"
#include "knuckle/data/readers/icg_source.h"
#include "knuckle/data/readers/icvl_source.h"
#include "knuckle/data/readers/mcap_source.h"
#include "knuckle/data/readers/mkv_source.h"
#include "knuckle/data/readers/msra15_source.h"
#include "knuckle/data/readers/nyu_source.h"
#include "knuckle/data/readers/rosbag_source.h"

namespace knuckle {
namespace {

template <class Source, class Options>
std::unique_ptr<FrameSource> open_with_options(const SourceSpec& spec) {
  return std::make_unique<Source>(spec.path, options_from<Options>(spec));
}

template <class Source>
std::unique_ptr<FrameSource> open_plain(const SourceSpec& spec) {
  require_no_settings(spec);
  return std::make_unique<Source>(spec.path);
}

/// One file, or all parts of a set that a pattern names.
std::unique_ptr<FrameSource> open_h5(const SourceSpec& spec) {
  require_no_settings(spec);
  if (names_several_files(spec.path)) return std::make_unique<H5PartsSource>(matching_files(spec.path));
  return std::make_unique<H5Source>(spec.path);
}

constexpr std::array kKinds{
    DatasetKind{"folder", "folder with dataset.toml and depth/*.png", open_plain<FolderSource>},
    DatasetKind{"icg", "ICG set, synthetic (EXR) or recorded (CSV)",
                open_with_options<IcgSource, IcgOptions>},
    DatasetKind{"icvl", "ICVL set: 16-bit PNG and labels.txt", open_with_options<IcvlSource, IcvlOptions>},
    DatasetKind{"nyu", "NYU set: RGB-coded PNG and joint_data.mat", open_with_options<NyuSource, NyuOptions>},
    DatasetKind{"msra15", "MSRA 2015 set: cropped .bin and joint.txt", open_plain<Msra15Source>},
    DatasetKind{"hands17", "HANDS 2017 challenge: 16-bit PNG and annotation file",
                open_with_options<Hands17Source, Hands17Options>},
    DatasetKind{"h5", "Knuckle dataset: one HDF5 file, or parts of it (parts/*.h5)", open_h5},
    DatasetKind{"fakenect", "recording of a Kinect: folder of libfreenect's fakenect-record",
                open_with_options<FakenectSource, FakenectOptions>},
    DatasetKind{"rosbag", "depth topic of a ROS 1 bag, RealSense's too",
                open_with_options<RosbagSource, RosbagOptions>},
    DatasetKind{"mcap", "depth topic of a ROS 2 recording (MCAP)",
                open_with_options<McapSource, McapOptions>},
    DatasetKind{"mkv", "recording of an Azure Kinect (k4arecorder)",
                open_with_options<MkvSource, MkvOptions>},
};

}  // namespace

std::span<const DatasetKind> dataset_kinds() {
  return kKinds;
}

std::unique_ptr<FrameSource> open_frames(const DatasetKind& kind, const SourceSpec& spec) {
  return select_frames(kind.open(spec), spec.selection, fmt::format("source '{}'", spec.text));
}

std::unique_ptr<FrameSource> open_dataset(const SourceSpec& spec) {
  const DatasetKind* const kind = row_named(kKinds, spec.kind);
  if (kind == nullptr) fail("source '{}': {}", spec.text, unknown_name("kind", spec.kind, names_of(kKinds)));
  return open_frames(*kind, spec);
}

std::unique_ptr<FrameSource> open_dataset(std::string_view text) {
  return open_dataset(parse_source_spec(text));
}

}  // namespace knuckle
