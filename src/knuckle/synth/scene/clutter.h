// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/synth/scene/contacts.h"
#include "knuckle/synth/scene/room.h"
#include "knuckle/synth/scene/scene_options.h"
#include "knuckle/synth/scene/table.h"

namespace knuckle {

/// Things that stand and lie on a table where the camera sees it. None touches skin or another thing: what
/// does is drawn again, a few times, and then left out.
std::vector<PlacedShape> things_on_table(const SceneActors& actors, const Table& table,
                                         const SceneOptions& options, Random& random);

/// Furniture on a room's floor, some way behind the hand and beside the table: cupboards, shelves with boxes,
/// posts.
std::vector<PlacedShape> furniture(const SceneActors& actors, const Room& room,
                                   const std::optional<Table>& table, const SceneOptions& options,
                                   Random& random);

/// Something that comes from outside the picture and ends or passes before the hand: a post, a cable, a
/// board's edge. Nothing where a few tries touch skin.
std::optional<PlacedShape> thing_before_hand(const SceneActors& actors, Random& random);

}  // namespace knuckle
