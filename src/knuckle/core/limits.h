// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

/// What a file may ask for at most, in one place. Readers and parsers compare with these before they take
/// memory, so that a small file cannot ask for a large machine.
namespace knuckle::limits {

inline constexpr int kImageSide = 16384;  ///< width or height of an image [px]
/// Of an image [px]: 8,000 x 6,000. As depth of a frame (float) it takes 192 MB, and about twice that while
/// it is read; a thread reads one frame at a time, so many threads take as many times that.
inline constexpr std::int64_t kImagePixels = 48'000'000;
inline constexpr std::int64_t kFrames = 1'000'000'000;               ///< of a source
inline constexpr int kHands = 64;                                    ///< of a frame
inline constexpr int kJoints = 1024;                                 ///< of a hand
inline constexpr int kTrees = 4096;                                  ///< of a forest
inline constexpr std::int64_t kForestNodes = std::int64_t{1} << 28;  ///< of a forest; indices have 32 bits
inline constexpr int kForestFeatures = 1 << 16;  ///< of a forest; nodes name them with 16 bits
inline constexpr std::int64_t kPatchFeatures = std::int64_t{1} << 26;  ///< of a network, of one patch
inline constexpr int kBones = 4096;                                    ///< of a body
inline constexpr double kDepthUnitMm = 1000.0;                         ///< of a count of depth [mm]
/// Of a set in one file each frame takes this many bytes of it or more: what lists an image alone takes more.
/// A few frames more are none too many for a small file.
inline constexpr std::int64_t kFrameBytes = 16;
inline constexpr std::int64_t kFewFrames = 65536;  ///< of such a set, beside those that its bytes allow
inline constexpr std::int64_t kNameLength = 4096;  ///< of a name in a file [bytes]
inline constexpr std::int64_t kLineLength = std::int64_t{1} << 20;      ///< of a line of a text file [bytes]
inline constexpr std::int64_t kTextFileBytes = std::int64_t{1} << 32;   ///< of a file of lines
inline constexpr std::int64_t kDocumentBytes = std::int64_t{16} << 20;  ///< of a TOML file
inline constexpr int kNesting = 64;  ///< tables and lists within one another, in TOML
inline constexpr std::int64_t kImageFileBytes = std::int64_t{1} << 30;  ///< of a PNG or EXR
inline constexpr std::int64_t kChunkBytes = std::int64_t{1} << 27;      ///< of a chunk of an HDF5 array
inline constexpr std::int64_t kObjectHeaderBytes = std::int64_t{16}
                                                   << 20;  ///< of an array's or a group's header in HDF5
inline constexpr std::int64_t kRecordHeaderBytes = std::int64_t{1}
                                                   << 20;  ///< of a record's header in a recording
inline constexpr std::int64_t kRecordingChunkBytes = std::int64_t{256}
                                                     << 20;  ///< of a recording's chunk, unpacked
/// What the chunks of a recording that does not list its messages unpack to: so many bytes, and so many
/// times the recording's own. Images without a single measurement are packed better, but are not all.
inline constexpr std::int64_t kUnpackedBytes = std::int64_t{1} << 30;
inline constexpr std::int64_t kUnpackedTimes = 100;  ///< of such a recording's own bytes
inline constexpr std::int64_t kRecordedMessages = std::int64_t{1}
                                                  << 22;  ///< of images and cameras in a recording
inline constexpr std::int64_t kRecordingElements = std::int64_t{1}
                                                   << 23;  ///< of a recording that is made of elements
inline constexpr std::size_t kRecordingTags = 4096;        ///< of tags, and of files within a recording
inline constexpr std::size_t kTracks = 256;                ///< of a recording
inline constexpr int kConnections = 16384;                 ///< of topics and publishers in a recording
inline constexpr std::uint64_t kCameraMessageBytes =
    std::uint64_t{64} << 20;                        ///< of a message of the process that reads a camera
inline constexpr std::int64_t kModelEntries = 256;  ///< of a model's file
inline constexpr std::int64_t kModelHeaderBytes = std::int64_t{4} << 20;  ///< of a model's header
inline constexpr std::int64_t kModelBytes = std::int64_t{512} << 20;  ///< of all that a model's file holds

}  // namespace knuckle::limits
