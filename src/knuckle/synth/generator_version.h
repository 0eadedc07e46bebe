// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace knuckle {

/// Which generator rendered a set: two of the same version make the same frames, to the bit, of the same
/// manifest. Raise it with every change after which a frame has other values (synthetic_source_test.cpp says
/// so): parts of a set that different versions rendered are not joined.
inline constexpr int kGeneratorVersion = 1;

}  // namespace knuckle
