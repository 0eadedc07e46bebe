// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/components.h"

#include <algorithm>
#include <cstddef>

#include <opencv2/imgproc.hpp>

#include "knuckle/core/image_cv.h"

namespace knuckle {

std::vector<std::vector<std::int32_t>> components_of(const Image<std::uint8_t>& mask) {
  if (mask.empty()) return {};
  Image<std::int32_t> labels(mask.width(), mask.height());
  cv::Mat_<std::int32_t> label_view = cv_view(labels);
  const int label_count = cv::connectedComponents(cv_view(mask), label_view, 8, CV_32S);
  std::vector<std::vector<std::int32_t>> components(
      static_cast<std::size_t>(std::max(label_count - 1, 0)));  // label 0: background
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const std::int32_t label = labels.data()[i];
    if (label > 0) components[static_cast<std::size_t>(label - 1)].push_back(static_cast<std::int32_t>(i));
  }
  return components;
}

}  // namespace knuckle
