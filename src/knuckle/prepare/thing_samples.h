// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "knuckle/prepare/network_samples.h"
#include "knuckle/prepare/sample_cutter.h"
#include "knuckle/segment/detector/hand_detector.h"

namespace knuckle {

/// Cuts out what is no hand, one thing a frame: from half of the frames what looks most like a hand to the
/// detector, from the others a random place of what is measured, and no place within 160 mm of a hand's
/// centre. None of the joints is known. Frames that have no such thing are left out, and counted as
/// `without_hand`. Of `options` the convention, the sizes, `most` and `holdout` count. On all threads;
/// depends on the frames alone. Throws an Error where the source has no truth, or no frame of it can be used.
NetworkSamples thing_samples(const std::string& source, const HandDetector& detector,
                             const SampleOptions& options);
/// Cuts them out one at a time.
std::unique_ptr<SampleCutter> thing_cutter(const std::string& source,
                                           std::shared_ptr<const HandDetector> detector,
                                           const SampleOptions& options);
/// Throws an Error that names the source where no frame of it shows a thing.
void require_things(const SampleFrames& frames, std::string_view source);

}  // namespace knuckle
