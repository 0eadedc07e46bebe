// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/core/options.h"

namespace knuckle {

/// The light that comes back to an active camera from a matt surface of one reflectance, lit from the
/// camera's place: amplitude = infrared cos(theta) / r^2, where r is the distance in metres along the line of
/// sight (Lambert's law and the inverse square; Foix, Alenya and Torras 2011).
struct InfraredOptions {
  double infrared = 0.0;        ///< amplitude of a surface that faces the camera at 1 m, in counts;
                                ///< 0: no infrared image, [0, 100000]
  double infrared_sigma = 0.0;  ///< deviation of its Gaussian noise, [0, 10000] [counts]

  void visit(OptionVisitor& visitor);
};

/// The amplitude image; 0 where the depth is 0, 65535 where it would be more. `cosines` (of the angle to the
/// surface's normal) may be empty: all surfaces face the camera.
Image<std::uint16_t> infrared_image(const Image<float>& depth_mm, const Image<float>& cosines,
                                    const Camera& camera, const InfraredOptions& options, std::uint64_t seed);

}  // namespace knuckle
