// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "knuckle/core/options.h"

namespace knuckle {

/// The `[tracker]` table of a pipeline file: how hands are followed from frame to frame (module `track`).
struct TrackerOptions {
  std::string smoothing = "kalman";  ///< none | one_euro | kalman, on angles and wrist
  double strength =
      1.0;  ///< of the smoothing, [0.01, 100]: divides cutoffs, multiplies noises; 0.5 is weak, 2 strong
  double search_every_s =
      0.1;                    ///< how often more hands are looked for while some are followed, [0, 3600] [s]
  double lost_after_s = 0.1;  ///< a hand that was not seen for longer is forgotten, [0, 3600] [s]
  double learn_s = 3.0;       ///< for so long a person's size is learned, then kept, [0, 3600] [s]

  void visit(OptionVisitor& visitor);
};

}  // namespace knuckle
