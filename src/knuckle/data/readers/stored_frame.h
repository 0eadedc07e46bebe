// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "knuckle/core/frame.h"

namespace knuckle {

/// One of the hands in a frame, as it will stand in a Knuckle dataset.
struct StoredHand {
  std::int8_t side = 0;
  std::array<std::uint8_t, kSupersetSize> occluders{};
  std::array<float, std::size_t{kSupersetSize} * 3> joints_mm{};
  double visible_share = 1.0;
};

/// The images of a frame as a Knuckle dataset has them.
struct StoredImages {
  Image<std::uint16_t> depth;          ///< counts, 0 = no measurement
  Image<std::uint16_t> infrared = {};  ///< empty where there is none
  Image<std::uint8_t> mask = {};       ///< the same
  Image<std::uint8_t> labels = {};     ///< the same
};

/// A frame as it will stand in a Knuckle dataset: its images as chunks of the file, compressed.
struct StoredFrame {
  Camera camera;
  std::int8_t side = 0;  ///< as in the file
  double time_s = kNaN;  ///< NaN where it is not known
  std::int32_t sequence = 0;
  std::array<float, std::size_t{kSupersetSize} * 3> joints_mm{};  ///< 22 x 3 in camera coordinates; NaN
  std::vector<std::uint8_t> depth = {};                           ///< counts, shuffled and deflated
  std::vector<std::uint8_t> infrared = {};                        ///< the same; empty where there is none
  std::vector<std::uint8_t> mask = {};                            ///< deflated; empty where there is none
  std::vector<std::uint8_t> labels = {};                          ///< the same
  std::uint64_t images_sum = 0;                                   ///< of all their pixels (frame_sums.h)
  std::vector<StoredHand> hands = {};                             ///< all in view
};

/// Encodes a frame; the costly part of writing it. Throws an Error that starts with `where` where a depth
/// exceeds what 16 bits hold.
StoredFrame stored_frame(const Frame& frame, double depth_unit_mm, std::string_view where);

/// Puts the images into the frame, as chunks, and notes their sum.
void pack(const StoredImages& images, StoredFrame& frame);

/// As one piece, for a FrameLog of this program.
std::vector<std::uint8_t> to_bytes(const StoredFrame& frame);
/// The frame from the bytes that `to_bytes` made. Throws an Error that starts with `where` where they are
/// others: a log may come from elsewhere.
StoredFrame stored_frame_from(std::span<const std::uint8_t> bytes, std::string_view where);

}  // namespace knuckle
