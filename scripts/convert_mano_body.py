# SPDX-License-Identifier: Apache-2.0
"""Makes a Knuckle body from the arrays of MANO and models like it (docs/import.md):

    python3 scripts/convert_mano_body.py MODEL.pkl|MODEL.npz --out body.model [--mirror]
        [--tips 745,317,444,556,673] [--joints wrist,index1,...]

Takes v_template V x 3 [m], f F x 3, weights V x B, J_regressor B x V, kintree_table 2 x B and, where it has
them, shapedirs V x 3 x K. Corrections that depend on the pose (posedirs) are dropped: Knuckle skins linearly.
"""
import argparse
import os
import sys
import zipfile

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import knuckle_body as kb  # noqa: E402
import knuckle_body_file  # noqa: E402
import knuckle_pickle  # noqa: E402

# MANO (Romero, Tzionas and Black, "Embodied hands", 2017): its joints in order, and the vertices of its mesh
# that are usually taken for the tips of thumb to little finger.
MANO_JOINTS = (
    "wrist",
    *(f"{finger}{k}" for finger in ("index", "middle", "little", "ring", "thumb") for k in (1, 2, 3)),
)
MANO_TIPS = (745, 317, 444, 556, 673)
LARGEST_M = 5.0  # no model of a person is larger; millimetres taken for metres are
REQUIRED = ("v_template", "f", "weights", "J_regressor", "kintree_table")


def parse_arguments():
    parser = argparse.ArgumentParser(description="arrays of MANO, or of a model like it, to a Knuckle body")
    parser.add_argument("model", help=".pkl (read without running it) or .npz")
    parser.add_argument("--out", required=True, help="the body file to write (.model)")
    parser.add_argument(
        "--joints",
        default=",".join(MANO_JOINTS),
        help="names of the joints in the model's order (default: MANO's); the hand's are wrist, thumb1 "
        "to thumb3, ..., little1 to little3, any others keep their name",
    )
    parser.add_argument(
        "--tips",
        default=",".join(map(str, MANO_TIPS)),
        help="vertices at the tips of thumb to little finger (default: %(default)s)",
    )
    parser.add_argument(
        "--mirror", action="store_true", help="the model is a left hand: exchange left and right"
    )
    return parser.parse_args()


def read_npz(path):
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except (ValueError, EOFError, OSError, zipfile.BadZipFile) as error:
        kb.fail(f"no whole .npz of plain arrays: {error}")


def read_model(path):
    """Name -> array of what the converter needs, in its expected shape."""
    try:
        with open(path, "rb") as file:
            is_zip = file.read(2) == b"PK"
        model = read_npz(path) if is_zip or path.endswith(".npz") else knuckle_pickle.read_pickle(path)
    except OSError as error:
        kb.fail(f"cannot be read: {error.strerror}")
    missing = [name for name in REQUIRED if name not in model]
    if missing:
        kb.fail(f"it lacks {', '.join(missing)}; it has {', '.join(sorted(map(str, model)))}")
    arrays = {
        name: knuckle_pickle.as_array(name, model[name]) for name in (*REQUIRED, "shapedirs") if name in model
    }
    vertex_count = len(arrays["v_template"])
    bone_count = arrays["weights"].shape[-1] if arrays["weights"].ndim else 0
    arrays.setdefault("shapedirs", np.zeros((vertex_count, 3, 0)))
    expected = {
        "v_template": (vertex_count, 3),
        "f": (None, 3),
        "weights": (vertex_count, bone_count),
        "J_regressor": (bone_count, vertex_count),
        "kintree_table": (2, bone_count),
        "shapedirs": (vertex_count, 3, None),
    }
    for name, shape in expected.items():
        found = arrays[name].shape
        if len(found) != len(shape) or any(want not in (None, got) for got, want in zip(found, shape)):
            kb.fail(f"{name} is {found}, expected {tuple('N' if want is None else want for want in shape)}")
        if arrays[name].dtype.kind not in "iuf":
            kb.fail(f"{name} holds {arrays[name].dtype}, expected numbers")
    return arrays


def parents_of(kintree_table):
    """B parents, -1 for a root; MANO writes the root's as 2^32 - 1."""
    above, own = kintree_table.astype(np.int64)
    number = {int(joint): index for index, joint in enumerate(own)}
    return np.array([number.get(int(joint), -1) for joint in above], np.int32)


def joint_groups(regressor, names):
    """The rows of J_regressor as vertex groups."""
    groups = []
    for name, row in zip(names, regressor):
        total = row.sum()
        if not abs(total - 1) <= 0.01:
            kb.fail(f"J_regressor of {name} sums to {total:.4g}, expected 1")
        vertices = np.flatnonzero(row)
        groups.append(kb.Group(vertices.astype(np.int32), (row[vertices] / total).astype(np.float32)))
    return groups


def tip_numbers(text, vertex_count):
    try:
        tips = [int(part) for part in text.split(",")]
    except ValueError:
        tips = []
    if len(tips) != 5 or not all(0 <= tip < vertex_count for tip in tips):
        kb.fail(f"--tips is '{text}', expected five vertices from 0 to {vertex_count - 1}")
    return tips


def landmark_of_joint():
    """'index1' -> 'index_mcp' and so on."""
    landmarks = {"wrist": "wrist"}
    for landmark in kb.generator_bone_names():
        if landmark != "wrist":
            finger = landmark.split("_")[0]
            landmarks[f"{finger}{1 + sum(name.startswith(finger) for name in landmarks)}"] = landmark
    return landmarks


def landmark_groups(joints, groups, tips):
    """The 22 landmarks' vertex groups and the bones that carry them."""
    number = {
        landmark: joints.index(joint) for joint, landmark in landmark_of_joint().items() if joint in joints
    }
    missing = [joint for joint in landmark_of_joint() if joint not in joints]
    if missing:
        kb.fail(f"--joints lacks {', '.join(missing)}")
    points = {landmark: groups[index] for landmark, index in number.items()}
    for finger, vertex in zip(kb.FINGERS, tips):
        points[f"{finger}_tip"] = kb.Group(np.array([vertex], np.int32), np.ones(1, np.float32))
        number[f"{finger}_tip"] = joints.index(f"{finger}3")
    points["palm"], number["palm"] = kb.palm_group(points), number["wrist"]
    return [points[name] for name in kb.LANDMARKS], np.array(
        [number[name] for name in kb.LANDMARKS], np.int32
    )


def convert(arguments):
    """The body, and the largest share of a vertex's weight that it drops."""
    model = read_model(arguments.model)
    joints = arguments.joints.split(",")
    if len(joints) != model["weights"].shape[1]:
        kb.fail(f"weights of {model['weights'].shape[1]} joints, but --joints names {len(joints)}")
    vertices = model["v_template"]
    if not np.isfinite(vertices).all():
        kb.fail(f"v_template of vertex {np.flatnonzero(~np.isfinite(vertices).all(axis=1))[0]} is not finite")
    if np.ptp(vertices, axis=0).max() > LARGEST_M:
        kb.fail(f"v_template spans {np.ptp(vertices, axis=0).max():.4g}, expected metres")
    weight_bones, weights, dropped = kb.strongest_weights(model["weights"])
    parents = parents_of(model["kintree_table"])
    groups = joint_groups(model["J_regressor"], joints)
    landmarks, landmark_bones = landmark_groups(joints, groups, tip_numbers(arguments.tips, len(vertices)))
    faces = model["f"].astype(np.int32)
    bone_names = {
        joint: kb.generator_bone_names()[landmark] for joint, landmark in landmark_of_joint().items()
    }
    hand = kb.descendants(parents, joints.index("wrist"))
    body = kb.Body(
        (1000 * vertices).astype(np.float32),
        faces,
        np.zeros(len(faces), np.uint8),
        weight_bones,
        weights,
        [bone_names.get(joint, joint) for joint in joints],
        parents,
        groups,
        landmarks,
        landmark_bones,
        [
            kb.sparse_direction(f"shape_{k:02}", 1000 * model["shapedirs"][:, :, k])
            for k in range(model["shapedirs"].shape[2])
        ],
    )
    kb.check(body)
    body.is_hand = kb.hand_faces(faces, weight_bones, weights, hand)
    return kb.mirrored(body) if arguments.mirror else body, dropped


def main():
    arguments = parse_arguments()
    try:
        body, dropped = convert(arguments)
        knuckle_body_file.write(body, arguments.out)
    except kb.BodyError as error:
        prefix = "" if str(error).startswith(arguments.out) else f"{arguments.model}: "
        print(f"convert_mano_body.py: {prefix}{error}", file=sys.stderr)
        sys.exit(1)
    if dropped > 1e-6:
        print(
            f"note: vertices with more than {kb.BONES_A_VERTEX} bones lose up to "
            f"{100 * dropped:.2g} % of their weight"
        )
    print(
        f"{arguments.out}: {len(body.v_template)} vertices, {len(body.faces)} faces, "
        f"{len(body.names)} bones, {len(body.shapedirs)} shape directions"
    )


if __name__ == "__main__":
    main()
