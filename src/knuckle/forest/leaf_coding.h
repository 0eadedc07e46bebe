// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "knuckle/forest/leaf_table.h"

namespace knuckle {

/// How finely a file keeps leaves: in steps along the principal components of all leaves. Most components of
/// poses vary by less than a step and take no room; a value is off by step / sqrt(12) in the mean of squares,
/// and the mean of many trees by less.
struct LeafCoding {
  float step = 0.0F;         ///< above 0, in units of the scaled targets
  std::vector<float> scale;  ///< what a unit of each target counts, above 0; one per target
};

/// Leaves as numbers of steps along principal components: leaf i is
///     (mean + sum over c of step * code(c, i) * component c) / scale.
struct CodedLeaves {
  float step = 0.0F;
  std::vector<float> scale;       ///< D
  std::vector<float> mean;        ///< D
  std::vector<float> components;  ///< D x D, a row per component, of length 1; the widest first
  std::vector<std::uint16_t>
      codes;  ///< D x leaves, a row per component; 0, -1, 1, -2, ... are 0, 1, 2, 3, ...
};

/// Throws an Error where the coding does not fit the leaves, or its step is too fine for 16 bits.
CodedLeaves coded(const LeafTable& leaves, const LeafCoding& coding);

/// The values back, a row per leaf. Throws an Error that starts with `origin` where the parts do not fit
/// together or are not finite.
std::vector<float> decoded(const CodedLeaves& coded, const std::string& origin);

}  // namespace knuckle
