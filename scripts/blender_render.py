# SPDX-License-Identifier: Apache-2.0
"""Renders the frames of a dump (tests/import/frame_dump.cpp) with Blender Cycles: a reference for Knuckle's.

    blender --background --factory-startup --python scripts/blender_render.py --
        DUMP.h5 --out OUT.npz [--frames N] [--threads N]

Blender does everything itself: its armature poses the mesh, Cycles renders depth and the hand's mask through
the pixels' centres. OUT: `depth_mm` N x H x W (0: nothing there), `mask` N x H x W, `vertices` N x V x 3 and
`landmarks` N x 22 x 3 in camera coordinates [mm], `setup_seconds`, and `frame_seconds` and
`frame_cpu_seconds` N (pose, render, write an EXR file).
"""
import argparse
import math
import os
import sys
import tempfile
import time

import bpy
import h5py
import numpy as np
from mathutils import Matrix, Quaternion, Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import knuckle_body_file  # noqa: E402
import knuckle_model_file  # noqa: E402

MM = 0.001  # Blender's unit is a metre
BLENDER_FROM_CAMERA = np.diag([1.0, -1.0, -1.0, 1.0])  # its camera looks along -z with y up
BODY_INDEX, HAND_INDEX = 1, 2
FARTHEST_M = 1e4  # Cycles marks an empty pixel by a depth of 1e10


def parse_arguments():
    parser = argparse.ArgumentParser(prog="blender_render.py")
    parser.add_argument("dump")
    parser.add_argument("--out", required=True)
    parser.add_argument("--frames", type=int, help="only the first of them")
    parser.add_argument("--threads", type=int, default=0, help="0: one per core")
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1 :])


def set_up_render(scene, camera, threads):
    """One ray a pixel, through its centre, without light: the fastest that Cycles does."""
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = (
        camera["width"],
        camera["height"],
        100,
    )
    render.use_persistent_data = True
    render.use_compositing, render.use_sequencer = True, False
    if threads > 0:
        render.threads_mode, render.threads = "FIXED", threads
    scene.cycles.device = "CPU"
    scene.cycles.samples = 1
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.filter_width = 0.01
    scene.cycles.max_bounces = 0
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_material_index = True


def set_up_camera(scene, camera):
    """A pinhole; cx and cy count from the first pixel's centre, fx and fy differ by the pixels' aspect."""
    thing = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(thing)
    scene.camera = thing
    width, height = camera["width"], camera["height"]
    aspect = camera["fx"] / camera["fy"]
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = max(1.0, 1.0 / aspect), max(1.0, aspect)
    data = thing.data
    data.sensor_fit, data.sensor_width = "HORIZONTAL", 36.0
    data.lens = camera["fx"] * data.sensor_width / width
    data.shift_x = (0.5 * (width - 1) - camera["cx"]) / width
    data.shift_y = (camera["cy"] - 0.5 * (height - 1)) * aspect / width
    data.clip_start, data.clip_end = 0.01, 100.0


def set_up_output(scene, folder):
    """Depth and material index as the first two channels of an EXR file of 32 bits."""
    scene.use_nodes = True
    nodes, links = scene.node_tree.nodes, scene.node_tree.links
    nodes.clear()
    layers = nodes.new("CompositorNodeRLayers")
    combine = nodes.new("CompositorNodeCombineColor")
    links.new(layers.outputs["Depth"], combine.inputs[0])
    links.new(layers.outputs["IndexMA"], combine.inputs[1])
    output = nodes.new("CompositorNodeOutputFile")
    output.base_path = folder
    output.file_slots[0].path = "frame_####"
    output.format.file_format, output.format.color_depth = "OPEN_EXR", "32"
    output.format.exr_codec = "NONE"
    links.new(combine.outputs[0], output.inputs[0])


def add_armature(scene, names, parents, joints_m):
    """Bones along y, so that a bone's own axes at rest are the body's."""
    armature = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for name, parent, joint in zip(names, parents, joints_m):
        bone = armature.data.edit_bones.new(name)
        bone.head, bone.tail, bone.roll = Vector(joint), Vector(joint) + Vector((0, 0.05, 0)), 0.0
        bone.parent = armature.data.edit_bones[names[parent]] if parent >= 0 else None
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature


def add_mesh(armature, names, vertices_m, faces, is_hand, weights):
    data = bpy.data.meshes.new("Body")
    data.from_pydata(vertices_m.tolist(), [], faces.tolist())
    for index in (BODY_INDEX, HAND_INDEX):
        material = bpy.data.materials.new(f"index {index}")
        material.pass_index = index
        data.materials.append(material)
    data.polygons.foreach_set("material_index", is_hand.astype(np.int32))
    data.update()
    mesh = bpy.data.objects.new("Body", data)
    bpy.context.scene.collection.objects.link(mesh)
    for bone, name in enumerate(names):
        group = mesh.vertex_groups.new(name=name)
        for vertex in np.flatnonzero(weights[:, bone]):
            group.add([int(vertex)], float(weights[vertex, bone]), "REPLACE")
    mesh.parent = armature
    modifier = mesh.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature
    return mesh


def pose(armature, names, rotations_wxyz, camera_from_body):
    armature.matrix_world = Matrix((BLENDER_FROM_CAMERA @ camera_from_body).tolist())
    for name, rotation in zip(names, rotations_wxyz):
        bone = armature.pose.bones[name]
        bone.rotation_mode = "QUATERNION"
        bone.rotation_quaternion = Quaternion(rotation.tolist())


def in_camera_mm(points):
    return np.asarray(points, np.float64) @ BLENDER_FROM_CAMERA[:3, :3] / MM


def posed_vertices(mesh):
    evaluated = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get())
    points = np.empty(3 * len(evaluated.data.vertices), np.float32)
    evaluated.data.vertices.foreach_get("co", points)
    world = np.array(evaluated.matrix_world, np.float64)
    return in_camera_mm(points.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3])


def posed_landmarks(armature, bones, rest_m):
    points = []
    for name, landmark in zip(bones, rest_m):
        bone = armature.pose.bones[name]
        points.append(
            armature.matrix_world @ bone.matrix @ bone.bone.matrix_local.inverted() @ Vector(landmark)
        )
    return in_camera_mm(points)


def read_image(path, camera):
    """Depth [mm] and mask of an EXR file; Blender's images begin at the bottom."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(4 * camera["width"] * camera["height"], np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    pixels = pixels.reshape(camera["height"], camera["width"], 4)[::-1]
    depth = np.where(pixels[..., 0] < FARTHEST_M, pixels[..., 0] / MM, 0)
    return depth.astype(np.float32), (np.rint(pixels[..., 1]) == HAND_INDEX).astype(np.uint8)


def main():
    arguments = parse_arguments()
    with h5py.File(arguments.dump, "r") as file:
        dump = {name: dataset[:] for name, dataset in file.items()}
        camera = {name: float(file.attrs[name]) for name in ("fx", "fy", "cx", "cy")}
        camera |= {name: int(file.attrs[name]) for name in ("width", "height")}
        body_path = file.attrs["body"]
    values, arrays = knuckle_model_file.read(
        body_path, knuckle_body_file.FORMAT, knuckle_body_file.VERSION
    )
    names = values["names"]
    parents, faces, is_hand, weights = (arrays[name] for name in ("parents", "faces", "is_hand", "weights"))
    landmark_bones = [names[bone] for bone in arrays["landmark_bones"]]
    count = min(arguments.frames or math.inf, len(dump["rotations_wxyz"]))

    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        set_up_render(scene, camera, arguments.threads)
        set_up_camera(scene, camera)
        set_up_output(scene, folder)
        armature = add_armature(scene, names, parents, MM * dump["rest_joints"].astype(np.float64))
        mesh = add_mesh(
            armature, names, MM * dump["rest_vertices"].astype(np.float64), faces, is_hand, weights
        )
        setup_seconds = time.perf_counter() - start

        seconds, cpu_seconds, results = [], [], {"depth_mm": [], "mask": [], "vertices": [], "landmarks": []}
        for index in range(count):
            start, cpu_start = time.perf_counter(), time.process_time()
            camera_from_body = dump["camera_from_body"][index].astype(np.float64)
            camera_from_body[:3, 3] *= MM
            pose(armature, names, dump["rotations_wxyz"][index], camera_from_body)
            scene.frame_current = index
            bpy.ops.render.render()
            seconds.append(time.perf_counter() - start)
            cpu_seconds.append(time.process_time() - cpu_start)

            depth, mask = read_image(os.path.join(folder, f"frame_{index:04}.exr"), camera)
            for name, value in (
                ("depth_mm", depth),
                ("mask", mask),
                ("vertices", posed_vertices(mesh)),
                ("landmarks", posed_landmarks(armature, landmark_bones, MM * dump["rest_landmarks"])),
            ):
                results[name].append(value)
    np.savez(
        arguments.out,
        setup_seconds=setup_seconds,
        frame_seconds=seconds,
        frame_cpu_seconds=cpu_seconds,
        **{name: np.array(values) for name, values in results.items()},
    )


main()
