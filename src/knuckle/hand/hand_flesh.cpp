// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_flesh.h"

#include <cstddef>

#include "knuckle/hand/landmark_points.h"

namespace knuckle {
namespace {

struct Radii {
  double from;
  double to;
};

/// Thumb to little, each from the palm outwards.
constexpr std::array<std::array<Radii, 3>, 5> kDigits = {{
    {{{0.220, 0.174}, {0.136, 0.094}, {0.110, 0.071}}},
    {{{0.121, 0.093}, {0.092, 0.080}, {0.080, 0.053}}},
    {{{0.136, 0.089}, {0.085, 0.076}, {0.077, 0.055}}},
    {{{0.122, 0.085}, {0.080, 0.074}, {0.076, 0.056}}},
    {{{0.139, 0.075}, {0.076, 0.066}, {0.070, 0.047}}},
}};
/// Index to little, from the wrist to the MCP.
constexpr std::array<Radii, 4> kPalm = {{{0.256, 0.163}, {0.249, 0.134}, {0.245, 0.129}, {0.257, 0.157}}};

std::array<HandFlesh, kFleshCount> all_flesh() {
  std::array<HandFlesh, kFleshCount> flesh;
  std::size_t count = 0;
  for (int digit = 0; digit < 5; ++digit) {
    if (digit > 0) {
      const Radii& palm = kPalm[static_cast<std::size_t>(digit - 1)];
      flesh[count++] = {Landmark::wrist, landmark_of_digit(digit, 0), palm.from, palm.to};
    }
    for (int part = 0; part < 3; ++part) {
      const Radii& radii = kDigits[static_cast<std::size_t>(digit)][static_cast<std::size_t>(part)];
      flesh[count++] = {landmark_of_digit(digit, part), landmark_of_digit(digit, part + 1), radii.from,
                        radii.to};
    }
  }
  return flesh;
}

}  // namespace

const std::array<HandFlesh, kFleshCount>& hand_flesh() {
  static const std::array<HandFlesh, kFleshCount> flesh = all_flesh();
  return flesh;
}

}  // namespace knuckle
