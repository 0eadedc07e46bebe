# SPDX-License-Identifier: Apache-2.0
"""Run inside Blender: builds a small hand (armature + cylinders) and saves it:

    blender --background --factory-startup --python blender_model.py -- FOLDER

It writes FOLDER/plain.blend and its faulty variants no_armature, two_meshes, nan_weight and lost_vertex. Both
objects stand moved, turned and scaled in the world; the mesh has two shape keys, one of them with a vertex
group.
"""
import math
import os
import sys

import bpy
from mathutils import Euler, Matrix, Vector

folder = sys.argv[sys.argv.index("--") + 1]
bpy.ops.wm.read_factory_settings(use_empty=True)

FINGERS = ("thumb", "index", "middle", "ring", "little")
SIDES = 10

# A right hand that hangs down, palm to the front (-y): the thumb on the figure's right (-x). Metres.
joints = {
    "arm": [Vector((0, 0, 0.25)), Vector((0, 0, 0))],
    "hand": [Vector((0, 0, 0)), Vector((0, 0, -0.08))],
}
for number, finger in enumerate(FINGERS):
    x, top = (-0.045, -0.03) if finger == "thumb" else (-0.05 + 0.021 * number, -0.085)
    joints[finger] = [Vector((x, 0.004 * k * k - 0.003 * k, top - 0.03 * k)) for k in range(4)]

armature = bpy.data.objects.new("Rig", bpy.data.armatures.new("RigData"))
bpy.context.scene.collection.objects.link(armature)
bpy.context.view_layer.objects.active = armature
bpy.ops.object.mode_set(mode="EDIT")


def add_bone(name, head, tail, parent, roll):
    bone = armature.data.edit_bones.new(name)
    bone.head, bone.tail, bone.roll = head, tail, roll
    bone.parent = armature.data.edit_bones.get(parent) if parent else None


add_bone("control", (0.3, 0, 0), (0.3, 0, 0.1), None, 0)  # moves no vertex and no bone that does
add_bone("arm", *joints["arm"], None, 0.3)
add_bone("hand", *joints["hand"], "arm", -0.7)
for finger in FINGERS:
    for k in range(3):
        add_bone(f"{finger}.{k + 1}", *joints[finger][k : k + 2], f"{finger}.{k}" if k else "hand", 0.2 * k)
bpy.ops.object.mode_set(mode="OBJECT")
armature.data.bones["control"].use_deform = False

vertices, faces, weights = [], [], []  # weights: a dict bone -> weight for each vertex


def add_tube(points, bones, radius):
    """Rings along the points, two between each pair; the skin blends from bone to bone around the joints."""
    stations = [k / 3 for k in range(3 * (len(points) - 1) + 1)]
    first = len(vertices)
    for station in stations:
        k = min(int(station), len(bones) - 1)
        centre = points[k].lerp(points[k + 1], station - k)
        near = round(station)
        share = {bones[k]: 1.0}
        if 0 < near < len(bones) and abs(station - near) < 0.4:
            after = 0.5 + 0.9 * (station - near)
            share = {
                bones[near - 1]: 0.8 * (1 - after),
                bones[near]: 0.8 * after,
            }  # sums to 0.8: is normalised
        for side in range(SIDES):
            angle = 2 * math.pi * side / SIDES
            vertices.append(centre + radius * Vector((math.cos(angle), math.sin(angle), 0)))
            weights.append(share)
    last = len(vertices) - SIDES
    for ring in range(first, last, SIDES):
        for side in range(SIDES):
            after = (side + 1) % SIDES
            faces.append((ring + after, ring + side, ring + SIDES + side, ring + SIDES + after))
    faces.append(tuple(range(first, first + SIDES)))
    faces.append(tuple(range(last + SIDES - 1, last - 1, -1)))


add_tube([joints["arm"][0], joints["arm"][1], joints["hand"][1]], ["arm", "hand"], 0.028)
for finger in FINGERS:
    add_tube(joints[finger], [f"{finger}.{k}" for k in (1, 2, 3)], 0.008)


def add_mesh(name):
    data = bpy.data.meshes.new(name)
    data.from_pydata(vertices, [], faces)
    data.update()
    mesh = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(mesh)
    for vertex, share in enumerate(weights):
        for bone, weight in share.items():
            group = mesh.vertex_groups.get(bone) or mesh.vertex_groups.new(name=bone)
            group.add([vertex], weight, "REPLACE")
    modifier = mesh.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature
    modifier.use_deform_preserve_volume = False
    mesh.shape_key_add(name="Basis")
    longer, fat = mesh.shape_key_add(name="longer"), mesh.shape_key_add(name="fat")
    for vertex, point in enumerate(vertices):
        longer.data[vertex].co = point + Vector((0, 0, 0.1 * min(0.0, point.z + 0.05)))
        fat.data[vertex].co = point + Vector((0, 0.2 * point.y, 0))
    fat.vertex_group = "hand"
    mesh.matrix_world = Matrix.LocRotScale(
        Vector((0.02, 0.01, 1.1)), Euler((0.1, -0.2, 0.3)), Vector((0.9, 0.9, 0.9))
    )
    return mesh


def save(variant):
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, f"{variant}.blend"), copy=True)


mesh = add_mesh("Hand")
armature.matrix_world = mesh.matrix_world
save("plain")
element = mesh.data.vertices[7].groups[0]
weight, element.weight = element.weight, float("nan")
save("nan_weight")
element.weight = weight
glove = add_mesh("Glove")
save("two_meshes")
bpy.data.objects.remove(glove)
for group in mesh.vertex_groups:
    group.remove([11])
save("lost_vertex")
bpy.data.objects.remove(armature)
save("no_armature")
