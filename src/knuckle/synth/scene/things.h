// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/synth/scene/shapes.h"

namespace knuckle {

/// The kinds of things that lie about: "box", "mug", ... in the order in which a manifest lists them.
std::span<const std::string_view> thing_kinds();

/// A thing of that kind in a random size of everyday. Throws an Error that lists the kinds where it is none.
Shape sampled_thing(std::string_view kind, Random& random);

/// A crumpled cloth that lies on z = 0: an open surface, seen from above.
Shape sampled_cloth(Random& random);

}  // namespace knuckle
