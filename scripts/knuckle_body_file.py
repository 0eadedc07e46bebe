# SPDX-License-Identifier: Apache-2.0
"""The `.h5` file of a body, as knuckle reads and writes it (src/knuckle/hand/body_file.h)."""
import os

import knuckle_body as kb
import numpy as np

FORMAT, VERSION = "knuckle-body", 1


def import_h5py():
    try:
        import h5py
    except ImportError:
        kb.fail(
            "the Python that runs this lacks h5py: install it "
            "(Debian: python3-h5py, which Debian's Blender finds)"
        )
    return h5py


def write(body, path):
    """Writes the body as knuckle reads it; the file appears only when whole."""
    kb.check(body)
    h5py = import_h5py()
    temporary = f"{path}.writing-{os.getpid()}"
    try:
        with h5py.File(temporary, "w") as file:
            write_arrays(file, body, h5py.string_dtype())
        with open(temporary, "rb") as file:
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        kb.fail(f"{path}: cannot be written: {error}")
    finally:
        if os.path.exists(temporary):
            os.remove(temporary)


def write_arrays(file, body, text):
    def add(name, values, dtype):
        values = np.asarray(values, dtype)
        file.create_dataset(name, data=values, **({"compression": 4} if values.size else {}))

    def add_rows(name, rows):
        """Row i is the entries starts[i] to starts[i + 1]."""
        add(f"{name}_starts", np.cumsum([0] + [len(row.vertices) for row in rows]), np.int64)
        add(f"{name}_vertices", np.concatenate([[], *(row.vertices for row in rows)]), np.int32)

    file.attrs.create("format", FORMAT, dtype=text)
    file.attrs["version"] = float(VERSION)
    file.attrs.create("unit", "mm", dtype=text)
    add("v_template", body.v_template, np.float32)
    add("faces", body.faces, np.int32)
    add("is_hand", body.is_hand, np.uint8)
    add("sections", [[len(body.v_template), len(body.faces)]], np.int32)
    add("weights", kb.dense_weights(body), np.float32)
    file.create_dataset("names", data=list(body.names), dtype=text)
    add("parents", body.parents, np.int32)
    file.create_dataset("shapedirs_names", data=[direction.name for direction in body.shapedirs], dtype=text)
    add_rows("shapedirs", body.shapedirs)
    offsets = [np.zeros((0, 3)), *(direction.offsets_mm for direction in body.shapedirs)]
    add("shapedirs_offsets", np.concatenate(offsets), np.float32)
    for name in ("joint_regressor", "landmark_regressor"):
        groups = getattr(body, name)
        add_rows(name, groups)
        add(f"{name}_weights", np.concatenate([group.weights for group in groups]), np.float32)
    file.create_dataset("landmark_names", data=list(kb.LANDMARKS), dtype=text)
    add("landmark_bones", body.landmark_bones, np.int32)


def read(path):
    """Reads a body that `write` or knuckle wrote."""
    with import_h5py().File(path, "r") as file:
        if file.attrs.get("format") != FORMAT or file.attrs.get("version") != VERSION:
            kb.fail(f"{path}: no {FORMAT} file of version {VERSION}")
        arrays = {
            name: dataset.asstr()[:].tolist() if dataset.dtype.kind == "O" else dataset[:]
            for name, dataset in file.items()
        }

    def rows(name, values):
        starts = arrays[f"{name}_starts"]
        return [
            (arrays[f"{name}_vertices"][first:last], arrays[f"{name}_{values}"][first:last])
            for first, last in zip(starts[:-1], starts[1:])
        ]

    bones, weights, _ = kb.strongest_weights(arrays["weights"])
    shapedirs = [
        kb.ShapeDirection(name, *row)
        for name, row in zip(arrays["shapedirs_names"], rows("shapedirs", "offsets"))
    ]
    return kb.Body(
        arrays["v_template"],
        arrays["faces"],
        arrays["is_hand"],
        bones,
        weights,
        arrays["names"],
        arrays["parents"],
        [kb.Group(*row) for row in rows("joint_regressor", "weights")],
        [kb.Group(*row) for row in rows("landmark_regressor", "weights")],
        arrays["landmark_bones"],
        shapedirs,
    )
