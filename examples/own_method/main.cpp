// SPDX-License-Identifier: Apache-2.0
// A pipeline of our own parts: palm and finger tip in each frame of a file of raw depths.
#include "ball_segmenter.h"
#include "pointing_estimator.h"
#include "raw_depth_source.h"

#include <cstdio>

#include <knuckle/pipeline/estimate_each.h>

int main(int argument_count, char** arguments) try {
  if (argument_count != 2) return std::fprintf(stderr, "usage: own_method DEPTH.f32\n"), 2;
  const own::RawDepthSource source(arguments[1]);
  const knuckle::Pipeline pipeline({
      .finder = knuckle::HandFinder(std::make_unique<own::BallSegmenter>(own::BallSegmenterOptions{})),
      .estimator = std::make_unique<own::PointingEstimator>(),
  });
  estimate_each(source, pipeline, {}, [](const knuckle::FrameResult& frame) {
    for (const knuckle::HandEstimate& hand : frame.estimate.hands) {
      for (const knuckle::ImagePoint& joint : hand.pose.joints)
        std::printf("%.2f %.2f %.1f  ", joint.u, joint.v, joint.depth_mm);
    }
    std::puts("");
  });
} catch (const std::exception& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
