// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "knuckle/prepare/network_samples.h"
#include "knuckle/segment/detector/hand_detector.h"

namespace knuckle {

/// Cuts out what is no hand, one thing a frame: from half of the frames what looks most like a hand to the
/// detector, from the others a random place of what is measured, and no place within 160 mm of a hand's
/// centre. None of the joints is known. Frames that have no such thing are left out, and counted as
/// `without_hand`. Of `options` the convention, the sizes, `most` and `holdout` count. On all threads;
/// depends on the frames alone. Throws an Error where the source has no truth, or no frame of it can be used.
NetworkSamples thing_samples(const std::string& source, const HandDetector& detector,
                             const SampleOptions& options);

}  // namespace knuckle
