// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "knuckle/data/frame_stream.h"

namespace knuckle {

/// What is known of a camera that is open.
struct CameraFacts {
  std::string device;      ///< what it calls itself; may hold any bytes
  std::string format;      ///< what it sends, as in "Z16 640x480, 30 per second"
  std::string intrinsics;  ///< where they are from; empty: they are not known
};

/// What to do with a camera whose intrinsics nobody told.
enum class UnknownIntrinsics {
  refuse,  ///< an Error: its depth cannot become points
  guess,   ///< frames get a field of view of 60 degrees: to look at the images alone
};

/// A live camera. Frames have times that begin at 0 with the first and never go back. `next` throws
/// DeviceLost where the camera is gone, and Interrupted where the program is asked to end while it waits.
class CameraStream : public FrameStream {
 public:
  virtual const CameraFacts& facts() const = 0;
};

}  // namespace knuckle
