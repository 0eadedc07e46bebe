// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// A depth image of a fakenect recording.
struct FakenectImage {
  std::string name;     ///< of its file, in the folder of the recording
  double time_s = 0.0;  ///< by the Kinect's clock [s]
  int sequence = 0;     ///< counts up where the clock goes back
};

/// The depth images that an INDEX.txt lists, in its order: lines `d-HOST_TIME-TICKS.pgm` (or `.dump`) with
/// seconds of the computer's clock and ticks of the Kinect's. Other letters (colour, accelerometer) are
/// passed over. The Kinect counts 60 million ticks per second in 32 bits, so they start again at 0 after
/// 71.6 s; how often they did between two images is told by the computer's clock. `where` is the file's name.
/// Throws an Error that names it and the line where a line is none of these or names a file elsewhere, and
/// where there is no depth image.
std::vector<FakenectImage> parse_fakenect_index(std::string_view text, std::string_view where);

}  // namespace knuckle
