// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// What a file may ask for at most, in one place. Readers and parsers compare with these before they take
/// memory, so that a small file cannot ask for a large machine.
namespace knuckle::limits {

inline constexpr int kImageSide = 16384;                                ///< width or height of an image [px]
inline constexpr std::int64_t kFrames = 1'000'000'000;                  ///< of a source
inline constexpr int kHands = 64;                                       ///< of a frame
inline constexpr int kJoints = 1024;                                    ///< of a hand
inline constexpr int kTrees = 4096;                                     ///< of a forest
inline constexpr int kBones = 4096;                                     ///< of a body
inline constexpr std::int64_t kNameLength = 4096;                       ///< of a name in a file [bytes]
inline constexpr std::int64_t kLineLength = std::int64_t{1} << 20;      ///< of a line of a text file [bytes]
inline constexpr std::int64_t kTextFileBytes = std::int64_t{1} << 32;   ///< of a file of lines
inline constexpr std::int64_t kDocumentBytes = std::int64_t{16} << 20;  ///< of a TOML file
inline constexpr int kNesting = 64;  ///< tables and lists within one another, in TOML
inline constexpr std::int64_t kImageFileBytes = std::int64_t{1} << 30;  ///< of a PNG or EXR
inline constexpr std::int64_t kChunkBytes = std::int64_t{1} << 29;      ///< of a chunk of an HDF5 array
inline constexpr std::int64_t kObjectHeaderBytes = std::int64_t{16}
                                                   << 20;  ///< of an array's or a group's header in HDF5
inline constexpr std::int64_t kRecordHeaderBytes = std::int64_t{1}
                                                   << 20;  ///< of a record's header in a recording
inline constexpr std::int64_t kRecordingChunkBytes = std::int64_t{256}
                                                     << 20;  ///< of a recording's chunk, unpacked
inline constexpr std::int64_t kRecordedMessages = std::int64_t{1}
                                                  << 24;  ///< of images and cameras in a recording
inline constexpr int kConnections = 16384;                ///< of topics and publishers in a recording
inline constexpr std::int64_t kModelEntries = 256;        ///< of a model's file
inline constexpr std::int64_t kModelHeaderBytes = std::int64_t{4} << 20;  ///< of a model's header
inline constexpr std::int64_t kModelBytes = std::int64_t{512} << 20;  ///< of all that a model's file holds

}  // namespace knuckle::limits
