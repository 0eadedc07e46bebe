// SPDX-License-Identifier: Apache-2.0
// What labels from files and pages may be.
#pragma once

namespace knuckle {

/// What lies outside of the image may be labelled, within reason.
inline constexpr double kFarthestLabelPx = 1e5;
inline constexpr double kFarthestLabelMm = 1e6;  ///< from the camera
/// How deep the JSON of labels and messages is nested.
inline constexpr int kDeepestLabelJson = 4;

}  // namespace knuckle
