# SPDX-License-Identifier: Apache-2.0
"""Makes a Knuckle body from an armature and the mesh that it moves in a .blend file (docs/import.md):

    blender --background FILE.blend --python scripts/export_blender_body.py -- --out body.model \
        [--armature NAME] [--mesh NAME] [--landmarks map.toml] [--mirror]
"""
import argparse
import os
import sys
import traceback

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import knuckle_body as kb  # noqa: E402
import knuckle_body_file  # noqa: E402
import knuckle_landmark_map as lm  # noqa: E402

# Blender's world has z up and figures face -y; Knuckle's body axes are x left, y up, z front.
BODY_FROM_WORLD = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], np.float64)


def parse_arguments():
    parser = argparse.ArgumentParser(
        prog="export_blender_body.py", description="Blender armature + mesh to a body"
    )
    parser.add_argument("--out", required=True, help="the body file to write (.model)")
    parser.add_argument("--armature", help="the armature object; needed where the file has several")
    parser.add_argument("--mesh", help="the mesh object; needed where the armature moves several")
    parser.add_argument("--landmarks", help="TOML map of the 22 landmarks; default: MakeHuman's bone names")
    parser.add_argument(
        "--mirror", action="store_true", help="the model is a left hand: exchange left and right"
    )
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])


def choose(kind, name, candidates, option):
    """The candidate of that name; without a name the only one."""
    names = ", ".join(sorted(candidate.name for candidate in candidates))
    if name is not None:
        for candidate in candidates:
            if candidate.name == name:
                return candidate
        kb.fail(f"no {kind} '{name}'; there is: {names or 'none'}")
    if not candidates:
        kb.fail(f"the file has no {kind}")
    if len(candidates) > 1:
        kb.fail(f"the file has {len(candidates)} of the kind '{kind}': choose one with {option}: {names}")
    return candidates[0]


def is_moved_by(mesh, armature):
    if mesh.parent == armature and mesh.parent_type == "ARMATURE":
        return True
    return any(modifier.type == "ARMATURE" and modifier.object == armature for modifier in mesh.modifiers)


def unit_in_mm(scene):
    """mm of one of Blender's units, as the scene's settings have it."""
    return 1000.0 * (scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0)


class Space:
    """From an object's own coordinates to Knuckle's body axes in mm."""

    def __init__(self, thing, unit_mm):
        world = np.array(thing.matrix_world, np.float64)
        self.linear = unit_mm * BODY_FROM_WORLD @ world[:3, :3]
        self.origin = unit_mm * BODY_FROM_WORLD @ world[:3, 3]

    def points(self, points):
        return np.asarray(points, np.float64) @ self.linear.T + self.origin

    def offsets(self, offsets):
        return np.asarray(offsets, np.float64) @ self.linear.T

    def flips(self):
        return np.linalg.det(self.linear) < 0


def coordinates(items, count):
    values = np.empty(3 * count, np.float32)
    items.foreach_get("co", values)
    return values.reshape(count, 3)


def rest_vertices(mesh):
    """V x 3, in the mesh's own coordinates: the shape at which all shape keys are 0."""
    keys = mesh.data.shape_keys
    return coordinates(keys.reference_key.data if keys else mesh.data.vertices, len(mesh.data.vertices))


def triangles(mesh):
    mesh.data.calc_loop_triangles()
    faces = np.empty(3 * len(mesh.data.loop_triangles), np.int32)
    mesh.data.loop_triangles.foreach_get("vertices", faces)
    return faces.reshape(-1, 3)


def group_weights(mesh, bones):
    """V x len(bones) weights of the vertex groups that have a bone's name."""
    column = {bone: number for number, bone in enumerate(bones)}
    columns = {group.index: column[group.name] for group in mesh.vertex_groups if group.name in column}
    weights = np.zeros((len(mesh.data.vertices), len(bones)), np.float32)
    for vertex in mesh.data.vertices:
        for element in vertex.groups:
            if element.group in columns:
                weights[vertex.index, columns[element.group]] = element.weight
    return weights


def bones_in_order(armature):
    """All bones, parents before children."""
    ordered = [bone for bone in armature.data.bones if bone.parent is None]
    for bone in ordered:  # grows while it is read
        ordered.extend(bone.children)
    return ordered


def with_ancestors(bones, wanted):
    """The bones of those names and all above them, in the order of `bones`."""
    keep = set(wanted)
    for bone in bones:
        if bone.name in wanted:
            keep.update(parent.name for parent in bone.parent_recursive)
    return [bone for bone in bones if bone.name in keep]


def shape_directions(mesh, space):
    """One direction a relative shape key; also what a key's vertex group does to it."""
    keys = mesh.data.shape_keys
    if keys is None:
        return []
    if not keys.use_relative:
        kb.fail(f"the shape keys of '{mesh.name}' are absolute, expected relative ones")
    count = len(mesh.data.vertices)
    directions = []
    for key in keys.key_blocks:
        if key == keys.reference_key:
            continue
        offsets = coordinates(key.data, count).astype(np.float64) - coordinates(key.relative_key.data, count)
        if key.vertex_group:
            offsets *= group_weights(mesh, [key.vertex_group])
        directions.append(kb.sparse_direction(key.name, space.offsets(offsets)))
    return directions


class Skeleton:
    """Bones of an armature, parents before children, among the vertices that they move."""

    def __init__(self, bones, space, vertices, dense):
        self.bones = bones
        self.number = {bone.name: index for index, bone in enumerate(bones)}
        self.parents = [self.number[bone.parent.name] if bone.parent else -1 for bone in bones]
        self.space = space
        self.vertices = vertices
        self.dense = dense

    def group(self, name, end):
        """A bone's head or tail by vertices that it or its parent moves, or by any where those do not do."""
        index = self.number[name]
        bone = self.bones[index]
        point = self.space.points(bone.head_local if end == "head" else bone.tail_local)
        columns = [index, self.parents[index]] if end == "head" and bone.parent else [index]
        members = np.flatnonzero(self.dense[:, columns].sum(axis=1) > 0.1)
        try:
            return kb.point_as_group(point, self.vertices, members)
        except kb.BodyError:
            return kb.point_as_group(point, self.vertices, np.arange(len(self.vertices)))

    def landmarks(self, landmark_map):
        """The 22 vertex groups and the bones that carry them."""
        groups, carriers = {}, {}
        for name, points in landmark_map.points.items():
            groups[name] = kb.mean_group([self.group(point.bone, point.end) for point in points])
            carriers[name] = self.number[points[0].bone]
        groups.setdefault("palm", kb.palm_group(groups))
        carriers.setdefault("palm", carriers["wrist"])
        return [groups[name] for name in kb.LANDMARKS], [carriers[name] for name in kb.LANDMARKS]


def notes(mesh, armature, dropped):
    """What the body does not have of the .blend file, a line each."""
    for modifier in mesh.modifiers:
        if modifier.type != "ARMATURE":
            yield f"the modifier '{modifier.name}' of '{mesh.name}' is not applied"
        elif modifier.use_deform_preserve_volume:
            yield f"'{mesh.name}' preserves volume (dual quaternions); a body file says nothing of that"
    if any(bone.bbone_segments > 1 for bone in armature.data.bones):
        yield "bendy bones become straight ones"
    if dropped > 1e-6:
        yield (
            f"vertices with more than {kb.BONES_A_VERTEX} bones lose up to "
            f"{100 * dropped:.1f} % of their weight"
        )


def choose_objects(arguments):
    """The armature, and the mesh that it moves."""
    if not bpy.data.filepath:
        kb.fail("no .blend file was read: name one before --python")
    armatures = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
    armature = choose("armature", arguments.armature, armatures, "--armature")
    meshes = [thing for thing in bpy.data.objects if thing.type == "MESH" and is_moved_by(thing, armature)]
    return armature, choose(f"mesh that '{armature.name}' moves", arguments.mesh, meshes, "--mesh")


def choose_landmarks(path, bones):
    landmark_map = lm.read_landmark_map(path) if path else lm.makehuman_map()
    lm.check_bones(
        landmark_map, path or "MakeHuman's landmarks (see --landmarks)", {bone.name for bone in bones}
    )
    return landmark_map


def body_of(armature, mesh, landmark_map):
    """The body, and the largest share of a vertex's weight that it drops."""
    groups = {group.name for group in mesh.vertex_groups}
    bones = bones_in_order(armature)
    moving = {bone.name for bone in bones if bone.use_deform and bone.name in groups}
    bones = with_ancestors(bones, moving | landmark_map.bones())
    dense = group_weights(mesh, [bone.name if bone.name in moving else None for bone in bones])
    weight_bones, weights, dropped = kb.strongest_weights(dense)

    unit_mm = unit_in_mm(bpy.context.scene)
    space = Space(mesh, unit_mm)
    vertices = space.points(rest_vertices(mesh)).astype(np.float32)
    faces = triangles(mesh)[:, ::-1] if space.flips() else triangles(mesh)
    skeleton = Skeleton(bones, Space(armature, unit_mm), vertices, dense)
    landmarks, landmark_bones = skeleton.landmarks(landmark_map)
    hand = kb.descendants(skeleton.parents, landmark_bones[kb.LANDMARKS.index("wrist")])
    body = kb.Body(
        v_template=vertices,
        faces=faces,
        is_hand=kb.hand_faces(faces, weight_bones, weights, hand),
        weight_bones=weight_bones,
        weights=weights,
        names=[landmark_map.renamed.get(bone.name, bone.name) for bone in bones],
        parents=np.array(skeleton.parents, np.int32),
        joint_regressor=[skeleton.group(bone.name, "head") for bone in bones],
        landmark_regressor=landmarks,
        landmark_bones=np.array(landmark_bones, np.int32),
        shapedirs=shape_directions(mesh, space),
    )
    return body, dropped


def export(arguments):
    armature, mesh = choose_objects(arguments)
    landmark_map = choose_landmarks(arguments.landmarks, armature.data.bones)
    body, dropped = body_of(armature, mesh, landmark_map)
    knuckle_body_file.write(kb.mirrored(body) if arguments.mirror else body, arguments.out)
    for note in notes(mesh, armature, dropped):
        print(f"note: {note}")
    print(
        f"{arguments.out}: {len(body.v_template)} vertices, {len(body.faces)} faces, "
        f"{len(body.names)} bones, {len(body.shapedirs)} shape directions"
    )


def main():
    arguments = parse_arguments()
    try:
        export(arguments)
    except kb.BodyError as error:
        named = str(error).startswith((arguments.out, arguments.landmarks or "\0"))
        prefix = "" if named or not bpy.data.filepath else f"{bpy.data.filepath}: "
        print(f"export_blender_body.py: {prefix}{error}", file=sys.stderr)
        sys.exit(1)
    except Exception:  # Blender itself would go on and exit with 0
        traceback.print_exc()
        sys.exit(1)


main()
