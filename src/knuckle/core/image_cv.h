// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>

#include "knuckle/core/image.h"

namespace knuckle {

/// An OpenCV header over the pixels of `image`: no copy, valid as long as the image lives and keeps its size.
template <class T>
cv::Mat_<T> cv_view(Image<T>& image) {
  return cv::Mat_<T>(image.height(), image.width(), image.data());
}

/// The same for reading. OpenCV has no constant matrix: do not write through it.
template <class T>
cv::Mat_<T> cv_view(const Image<T>& image) {
  return cv::Mat_<T>(image.height(), image.width(), const_cast<T*>(image.data()));
}

}  // namespace knuckle
