// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/camera.h"
#include "knuckle/data/frame_record.h"
#include "knuckle/pipeline/estimate_each.h"

namespace knuckle {

/// What was found in a frame, as a record: hands are numbered by their rank, from 1. `origin` is the source's
/// pixel origin.
FrameRecord record_of(const FrameResult& result, PixelOrigin origin);

}  // namespace knuckle
