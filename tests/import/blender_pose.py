# SPDX-License-Identifier: Apache-2.0
"""Run inside Blender on a model of blender_model.py: what Blender's own armature makes of poses and shapes:

    blender --background FILE.blend --python blender_pose.py -- POSES.npz OUT.npz

POSES: `names` B bones, `rotations` N x B x 3 x 3 (a bone's turn about its head relative to its parent, in
Knuckle's body axes), `shapes` N x K values of the shape keys. OUT: `vertices` N x V x 3 and `heads` N x B x 3
in the world.
"""
import sys

import bpy
import numpy as np
from mathutils import Matrix

source, target = sys.argv[sys.argv.index("--") + 1 :]
poses = np.load(source)
armature = next(thing for thing in bpy.data.objects if thing.type == "ARMATURE")
mesh = next(thing for thing in bpy.data.objects if thing.type == "MESH")
world_from_body = Matrix(((1, 0, 0), (0, 0, -1), (0, 1, 0)))

vertices, heads = [], []
for rotations, shape in zip(poses["rotations"], poses["shapes"]):
    for key, value in zip(mesh.data.shape_keys.key_blocks[1:], shape):
        key.slider_min, key.slider_max = -10, 10
        key.value = value
    for name, rotation in zip(poses["names"], rotations):
        bone = armature.pose.bones[str(name)]
        frame = (armature.matrix_world @ bone.bone.matrix_local).to_3x3().normalized()
        turn = world_from_body @ Matrix(rotation.tolist()) @ world_from_body.transposed()
        bone.rotation_mode = "QUATERNION"
        bone.rotation_quaternion = (frame.transposed() @ turn @ frame).to_quaternion()
    bpy.context.view_layer.update()
    evaluated = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get())
    points = np.empty(3 * len(evaluated.data.vertices), np.float32)
    evaluated.data.vertices.foreach_get("co", points)
    world = np.array(mesh.matrix_world)
    vertices.append(points.reshape(-1, 3).astype(np.float64) @ world[:3, :3].T + world[:3, 3])
    heads.append(
        [list(armature.matrix_world @ armature.pose.bones[str(name)].head) for name in poses["names"]]
    )
np.savez(target, vertices=vertices, heads=heads)
