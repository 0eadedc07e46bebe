// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"

namespace knuckle {

/// A search for hands looks at no more measured pixels than this, about a 320 x 240 image of them: what it
/// costs does not grow with the image.
inline constexpr int kMostSearched = 80'000;

/// The smallest step, at least 1 [px], with which no more than `most` of the image's measured pixels are left
/// where only each step-th column and row is kept; counted as if they were spread evenly.
int search_stride(const Image<float>& depth_mm, int most = kMostSearched);

/// Each stride-th column and row of an image, the first included: pixel (i, j) is pixel (stride i, stride j).
Image<float> thinned(const Image<float>& depth_mm, int stride);
/// The camera of that image.
Camera thinned(Camera camera, int stride);

}  // namespace knuckle
