// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "knuckle/core/image.h"
#include "knuckle/core/options.h"

namespace knuckle {

/// Gaussian noise along z whose deviation is
///
///     sigma(z, theta) = sigma + growth z^2 + slant theta^2 / (pi / 2 - theta)^2,   z in metres,
///
/// constant in the framework paper (3 mm); quadratic in range for triangulation, where the error of a
/// disparity is constant (Khoshelham and Oude Elberink 2012), and about so for time of flight over
/// an interaction's range; the angle's term is that of Nguyen, Izadi and Lovell 2012 and of
/// Fankhauser et al. 2015, without its weak dependence on range.
struct RangeNoiseOptions {
  double sigma_mm = 3.0;   ///< at no range, [0, 100] [mm]
  double growth_mm = 0.0;  ///< what is added at 1 m, [0, 1000] [mm]
  double slant_mm = 0.0;   ///< what is added at an angle of 45 degrees, [0, 100] [mm]
  int grain_px = 1;        ///< noise is alike over so many pixels; 1: every pixel has its own, [1, 64] [px]

  void visit(OptionVisitor& visitor);
};

/// The deviation of that noise [mm]. The angle's term stops growing at 85 degrees.
double range_sigma_mm(const RangeNoiseOptions& options, double depth_mm, double cosine);

/// `depth_mm` with noise where it is not 0. `cosines` (of the angle to the surface's normal) may be empty:
/// all surfaces face the camera. A pixel's noise depends on `seed` and its place alone.
Image<float> with_range_noise(Image<float> depth_mm, const Image<float>& cosines,
                              const RangeNoiseOptions& options, std::uint64_t seed);

}  // namespace knuckle
