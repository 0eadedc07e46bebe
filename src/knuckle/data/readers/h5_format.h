// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "knuckle/core/camera.h"
#include "knuckle/core/frame.h"
#include "knuckle/storage/hdf5/hdf5_file.h"

namespace knuckle {

// The Knuckle dataset, an HDF5 file, version 3. Attributes of the root: `format`, `version`, `complete` (1
// once all frames are in), `first_index`, `manifest` (text), `generator` (text: the program and version that
// rendered the frames; may be missing), `depth_unit_mm` (millimetres a count of depth),
// `joints_unit`, `landmarks` (names of the rows of joints_mm), `pixel_origin` ("centre"), `camera_model`,
// `width`, `height`, `fx`, `fy`, `cx`, `cy`, `distortion` (8, OpenCV's order); in a part of a set that was
// made in several, `part_of_first` and `part_of_count`, the frames of the whole. Arrays, a row per frame:

inline constexpr std::string_view kH5Depth = "depth";        ///< N x H x W uint16, 0 = no measurement
inline constexpr std::string_view kH5Mask = "mask";          ///< N x H x W uint8, 1 = hand; may be missing
inline constexpr std::string_view kH5Infrared = "infrared";  ///< N x H x W uint16; may be missing
inline constexpr std::string_view kH5Joints = "joints_mm";   ///< N x 22 x 3 float32, in camera; NaN = unknown
/// N x 4 float64, fx, fy, cx, cy of each frame's camera; version 1 has none: all are those of the attributes.
inline constexpr std::string_view kH5Intrinsics = "intrinsics";
/// N int8: 0 = a right hand, 1 = a left one, -1 = not known; may be missing.
inline constexpr std::string_view kH5Side = "side";
/// N float64, when each frame was taken [s]: finite, never back within a sequence; may be missing.
inline constexpr std::string_view kH5Time = "time_s";
/// N int32, the number of each frame's sequence: at least 0, never back; missing: all frames are of sequence
/// 0.
inline constexpr std::string_view kH5Sequence = "sequence";

/// N x 2 uint64, the sums of each frame's numbers and images (frame_sums.h); missing before version 3.
inline constexpr std::string_view kH5FrameSums = "frame_sums";

/// N x H x W uint8, a PixelLabel each; may be missing.
inline constexpr std::string_view kH5Labels = "labels";
// All hands in view, frame by frame, M in all; these arrays may be missing, all together.
/// N int64: how many of the M belong to this frame and those before.
inline constexpr std::string_view kH5HandsEnd = "hands_end";
inline constexpr std::string_view kH5HandsSide = "hands_side";         ///< M int8, as `side`
inline constexpr std::string_view kH5HandsJoints = "hands_joints_mm";  ///< M x 22 x 3 float32, as `joints_mm`
/// M x 22 uint8, an Occluder each: what lies before the landmark.
inline constexpr std::string_view kH5HandsOccluders = "hands_occluders";
/// M float64: the part of a hand's pixels that nothing else hides, [0, 1].
inline constexpr std::string_view kH5HandsVisible = "hands_visible_share";

/// Attribute: the program that rendered the frames.
inline constexpr std::string_view kH5Generator = "generator";
/// Attribute of a part of a set: number of the whole set's first frame.
inline constexpr std::string_view kH5PartOfFirst = "part_of_first";
/// Attribute of a part of a set: frames of the whole set.
inline constexpr std::string_view kH5PartOfCount = "part_of_count";

/// What the file calls itself.
inline constexpr std::string_view kH5Format = "knuckle-dataset";
/// The newest version that is known; 2 added the intrinsics of each frame, 3 its sums.
inline constexpr int kH5Version = 3;
/// The first version whose files have sums: in these none may be missing.
inline constexpr int kH5VersionWithSums = 3;

/// The side as its number in the file, and back. Throws an Error that starts with `where` at other numbers.
std::int8_t code_of(std::optional<HandSide> side);
/// The side from that number.
std::optional<HandSide> side_of(std::int8_t code, std::string_view where);

/// Throws an Error that names the file where the attributes are missing or impossible.
Camera read_camera(const Hdf5File& file);

}  // namespace knuckle
