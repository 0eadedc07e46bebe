// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/surroundings.h"

#include <optional>

#include "knuckle/synth/scene/clutter.h"
#include "knuckle/synth/scene/room.h"
#include "knuckle/synth/scene/table.h"

namespace knuckle {
namespace {

// Streams of a scene's seed.
constexpr std::uint64_t kTable = 0;
constexpr std::uint64_t kRoom = 1;
constexpr std::uint64_t kFurniture = 2;
constexpr std::uint64_t kThings = 3;
constexpr std::uint64_t kBefore = 4;

void append(SceneMesh& mesh, const std::vector<PlacedShape>& things) {
  for (const PlacedShape& thing : things) mesh.append(thing.shape.mesh, thing.camera_from_shape);
}

}  // namespace

Surroundings sampled_surroundings(const SceneActors& actors, const SceneOptions& options,
                                  std::uint64_t seed) {
  Surroundings around;
  Random for_table(seed, kTable);
  Random for_room(seed, kRoom);
  Random for_furniture(seed, kFurniture);
  Random for_things(seed, kThings);
  Random for_before(seed, kBefore);
  std::optional<Table> table;
  if (for_table.uniform() < options.table_share) table = sampled_table(actors, options, for_table);
  const bool has_room = for_room.uniform() < options.room_share;
  const Room room = sampled_room(actors, table, for_room);
  if (has_room) around.room = mesh_of(room);
  append(around.room, furniture(actors, room, table, options, for_furniture));
  if (table) {
    append(around.room, {shape_of(*table)});
    append(around.things, things_on_table(actors, *table, options, for_things));
  }
  if (for_before.uniform() < options.before_share) {
    if (const auto thing = thing_before_hand(actors, for_before)) append(around.before, {*thing});
  }
  return around;
}

}  // namespace knuckle
