// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/tracker_options.h"

#include <array>

namespace knuckle {

void TrackerOptions::visit(OptionVisitor& visitor) {
  static constexpr std::array<std::string_view, 3> kSmoothings{"none", "one_euro", "kalman"};
  visitor.choice("smoothing", smoothing, kSmoothings);
  visitor.real("strength", strength, closed(0.01, 100));
  visitor.real("search_every_s", search_every_s, closed(0, 3600));
  visitor.real("lost_after_s", lost_after_s, closed(0, 3600));
  visitor.real("learn_s", learn_s, closed(0, 3600));
}

}  // namespace knuckle
