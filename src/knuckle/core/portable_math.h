// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace knuckle {

/// Elementary functions that give the same bits on every processor, for what is random or rendered. Those of
/// the C library round differently where the processor can multiply and add in one step (glibc 2.36: one sine
/// in 1,600). Errors stay within 6 units in the last place; arguments are finite.

/// Of angles within a million [rad].
double portable_sin(double angle);
/// Of angles within a million [rad].
double portable_cos(double angle);
/// The natural logarithm of a number above 0; of 0 it is minus infinity.
double portable_log(double value);
/// e to the power `exponent`; infinite or 0 where that is out of range.
double portable_exp(double exponent);
/// `base` to the power `exponent`, of a base above 0: its relative error is up to that of `portable_exp` by 1
/// + |exponent log base|.
double portable_pow(double base, double exponent);
/// The angle of (x, y) to the x axis, in [-pi, pi]; 0 for (0, 0).
double portable_atan2(double y, double x);
/// In [0, pi], of a cosine in [-1, 1].
double portable_acos(double cosine);
/// In [-pi / 2, pi / 2], of a sine in [-1, 1].
double portable_asin(double sine);

}  // namespace knuckle
