# SPDX-License-Identifier: Apache-2.0
"""The file of a body, as knuckle reads and writes it (src/knuckle/hand/body_file.h)."""
import knuckle_body as kb
import knuckle_model_file
import numpy as np

FORMAT, VERSION = "knuckle-body", 2


def write(body, path):
    """Writes the body as knuckle reads it; the file appears only when whole."""
    kb.check(body)
    try:
        knuckle_model_file.write(path, FORMAT, VERSION, values_of(body), arrays_of(body))
    except OSError as error:
        kb.fail(f"{path}: cannot be written: {error}")


def values_of(body):
    return {
        "unit": "mm",
        "names": [str(name) for name in body.names],
        "shapedirs_names": [direction.name for direction in body.shapedirs],
        "landmark_names": list(kb.LANDMARKS),
    }


def arrays_of(body):
    arrays = {}

    def add(name, values, dtype):
        arrays[name] = np.asarray(values, dtype)

    def add_rows(name, rows):
        """Row i is the entries starts[i] to starts[i + 1]."""
        add(f"{name}_starts", np.cumsum([0] + [len(row.vertices) for row in rows]), np.int64)
        add(f"{name}_vertices", np.concatenate([[], *(row.vertices for row in rows)]), np.int32)

    add("v_template", body.v_template, np.float32)
    add("faces", body.faces, np.int32)
    add("is_hand", body.is_hand, np.uint8)
    add("sections", [[len(body.v_template), len(body.faces)]], np.int32)
    add("weights", kb.dense_weights(body), np.float32)
    add("parents", body.parents, np.int32)
    add_rows("shapedirs", body.shapedirs)
    offsets = [np.zeros((0, 3)), *(direction.offsets_mm for direction in body.shapedirs)]
    add("shapedirs_offsets", np.concatenate(offsets), np.float32)
    for name in ("joint_regressor", "landmark_regressor"):
        groups = getattr(body, name)
        add_rows(name, groups)
        add(f"{name}_weights", np.concatenate([group.weights for group in groups]), np.float32)
    add("landmark_bones", body.landmark_bones, np.int32)
    return arrays


def read(path):
    """Reads a body that `write` or knuckle wrote."""
    try:
        values, arrays = knuckle_model_file.read(path, FORMAT, VERSION)
    except knuckle_model_file.ModelFileError as error:
        kb.fail(str(error))

    def rows(name, entries):
        starts = arrays[f"{name}_starts"]
        return [
            (arrays[f"{name}_vertices"][first:last], arrays[f"{name}_{entries}"][first:last])
            for first, last in zip(starts[:-1], starts[1:])
        ]

    bones, weights, _ = kb.strongest_weights(arrays["weights"])
    shapedirs = [
        kb.ShapeDirection(name, *row)
        for name, row in zip(values["shapedirs_names"], rows("shapedirs", "offsets"))
    ]
    return kb.Body(
        arrays["v_template"],
        arrays["faces"],
        arrays["is_hand"],
        bones,
        weights,
        values["names"],
        arrays["parents"],
        [kb.Group(*row) for row in rows("joint_regressor", "weights")],
        [kb.Group(*row) for row in rows("landmark_regressor", "weights")],
        arrays["landmark_bones"],
        shapedirs,
    )
