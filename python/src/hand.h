// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include "knuckle/core/camera.h"
#include "knuckle/data/frame_record.h"
#include "knuckle/hand/hand_angles.h"
#include "knuckle/track/tracker.h"

namespace knuckle::python {

/// Joint angles as a dict of name and value [rad], and back: an angle that is not in it is 0. Throws an Error
/// where a name is not known or a value is not finite.
pybind11::dict dict_of(const HandAngles& angles);
HandAngles angles_from(const pybind11::dict& angles);

/// A hand that is followed, as Python shows hands.
HandRecord record_of(const TrackedHand& hand, const Camera& camera);

}  // namespace knuckle::python
