# SPDX-License-Identifier: Apache-2.0
"""The converter of MANO-style arrays on random models of MANO's sizes, in every form that such files have."""
import os
import pickle
import struct
import subprocess
import sys
import types
import unittest

from import_testing import SCRIPTS, ImportTest, bone_transforms, random_rotations, run_python, shaped, skinned

import knuckle_body as kb
import knuckle_body_file
import numpy as np

CONVERTER = SCRIPTS / "convert_mano_body.py"
VERTICES, JOINTS, SHAPES = 778, 16, 10
PARENTS = [-1, 0, 1, 2, 0, 4, 5, 0, 7, 8, 0, 10, 11, 0, 13, 14]


def random_model(seed=5, bones_per_vertex=4):
    """Arrays of MANO's shapes and types; a cloud of the size of a hand."""
    random = np.random.default_rng(seed)
    weights = np.zeros((VERTICES, JOINTS))
    for row in weights:
        row[random.choice(JOINTS, bones_per_vertex, replace=False)] = random.dirichlet(np.ones(bones_per_vertex))
    regressor = np.zeros((JOINTS, VERTICES))
    for row in regressor:
        row[random.choice(VERTICES, 12, replace=False)] = random.dirichlet(np.ones(12))
    return {
        "v_template": random.uniform([-0.09, -0.02, -0.04], [0.1, 0.02, 0.04], (VERTICES, 3)),
        "f": random.integers(0, VERTICES, (1538, 3)).astype(np.uint32),
        "weights": weights,
        "J_regressor": regressor,
        "shapedirs": random.normal(0, 0.002, (VERTICES, 3, SHAPES)),
        "posedirs": random.normal(size=(VERTICES, 3, 135)),
        "kintree_table": np.array([[2**32 - 1, *PARENTS[1:]], range(JOINTS)], np.uint32),
    }


class Python2Pickler(pickle._Pickler):  # pylint: disable=protected-access
    """Writes texts and bytes as Python 2 wrote its str."""

    dispatch = dict(pickle._Pickler.dispatch)  # pylint: disable=protected-access

    def save_str2(self, value):
        data = value.encode("latin1") if isinstance(value, str) else value
        self.write(pickle.BINSTRING + struct.pack("<i", len(data)) + data)
        self.memoize(value)

    dispatch[str] = dispatch[bytes] = save_str2


def foreign_object(module, name, **state):
    """An object of a class of a package that is not installed, for pickling only."""
    parts = module.split(".")
    for length in range(1, len(parts) + 1):  # pickle imports the packages above, too
        made = sys.modules.setdefault(".".join(parts[:length]), types.ModuleType(module))
    kind = getattr(made, name, None) or type(name, (), {"__module__": module})
    setattr(made, name, kind)
    result = kind()
    result.__dict__.update(state)
    return result


def csc(dense):
    columns, rows = np.nonzero(dense.T)
    starts = np.searchsorted(columns, np.arange(dense.shape[1] + 1)).astype(np.int32)
    return foreign_object(
        "scipy.sparse.csc",
        "csc_matrix",
        _shape=dense.shape,
        maxprint=50,
        data=dense[rows, columns],
        indices=rows.astype(np.int32),
        indptr=starts,
    )


def as_published(model):
    """The model with the objects that MANO's own files hold."""
    wide = np.concatenate([model["shapedirs"], np.ones((VERTICES, 3, 3))], axis=2)
    chosen = np.arange(wide.size).reshape(wide.shape)[:, :, :SHAPES].ravel()
    inner = foreign_object("chumpy.ch", "Ch", x=wide, _status="new")
    return model | {
        "J_regressor": csc(model["J_regressor"]),
        "v_template": foreign_object("chumpy.ch", "Ch", x=model["v_template"]),
        "shapedirs": foreign_object(
            "chumpy.reordering", "Select", a=inner, idxs=chosen, preferred_shape=model["shapedirs"].shape
        ),
    }


class Attack:
    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.system, (f"touch {self.path}",)


class ManoConvertTest(ImportTest):
    def setUp(self):
        self.model = random_model()
        self.out = self.folder / f"{self.id().rsplit('.', 1)[1]}.model"

    def save_npz(self, **changes):
        path = self.folder / "model.npz"
        np.savez(path, **{name: value for name, value in (self.model | changes).items() if value is not None})
        return path

    def save_pickle(self, model, protocol=2):
        path = self.folder / "model.pkl"
        path.write_bytes(pickle.dumps(model, protocol=protocol))
        return path

    def converted(self, path, *options):
        self.assert_done(run_python(CONVERTER, path, "--out", self.out, *options))
        body = knuckle_body_file.read(self.out)
        self.assert_invariants(body)
        return body

    def assert_is_the_model(self, body):
        np.testing.assert_allclose(body.v_template, 1000 * self.model["v_template"], atol=1e-4)
        np.testing.assert_array_equal(body.faces, self.model["f"])
        np.testing.assert_array_equal(body.parents, PARENTS)
        np.testing.assert_allclose(kb.dense_weights(body), self.model["weights"], atol=1e-6)
        self.assertEqual(len(body.shapedirs), SHAPES)

    def test_poses_and_shapes_as_the_model_does(self):
        body = self.converted(self.save_npz())
        self.assert_is_the_model(body)
        random = np.random.default_rng(2)
        for _ in range(5):
            coefficients, rotations = random.normal(size=SHAPES), random_rotations(random, JOINTS)
            vertices = self.model["v_template"] + self.model["shapedirs"] @ coefficients
            heads = self.model["J_regressor"] @ vertices
            transforms = bone_transforms(body, heads, rotations)
            blended = np.einsum("vb,bij->vij", self.model["weights"], transforms)
            expected = np.einsum("vij,vj->vi", blended[:, :3, :3], vertices) + blended[:, :3, 3]

            own_vertices = shaped(body, coefficients)
            own_heads = np.array([group.position(own_vertices) for group in body.joint_regressor])
            np.testing.assert_allclose(own_heads, 1000 * heads, atol=1e-3)
            own = skinned(body, own_vertices, bone_transforms(body, own_heads, rotations))
            np.testing.assert_allclose(own, 1000 * expected, atol=1e-3)

    def test_reads_pickles_of_all_ages(self):
        for protocol in (0, 2, 4, 5):
            with self.subTest(protocol=protocol):
                self.assert_is_the_model(self.converted(self.save_pickle(as_published(self.model), protocol)))
        path = self.folder / "python2.pkl"
        with open(path, "wb") as file:
            Python2Pickler(file, protocol=2).dump(as_published(self.model))
        self.assertNotIn(b"_codecs", path.read_bytes())
        self.assert_is_the_model(self.converted(path))

    def test_names_bones_as_the_generator_does(self):
        body = self.converted(self.save_npz())
        self.assertEqual(body.names[:4], ["wrist.R", "finger2-1.R", "finger2-2.R", "finger2-3.R"])
        self.assertEqual(body.names[7], "finger5-1.R")  # MANO's little finger comes before the ring finger
        self.assertEqual(body.names[15], "finger1-3.R")
        vertices = body.v_template.astype(np.float64)
        points = {
            name: group.position(vertices) for name, group in zip(kb.LANDMARKS, body.landmark_regressor)
        }
        joints = 1000 * self.model["J_regressor"] @ self.model["v_template"]
        np.testing.assert_allclose(points["little_pip"], joints[8], atol=1e-3)
        np.testing.assert_allclose(points["thumb_cmc"], joints[13], atol=1e-3)
        np.testing.assert_allclose(points["thumb_tip"], vertices[745])
        np.testing.assert_allclose(points["little_tip"], vertices[673])
        np.testing.assert_allclose(
            points["palm"], (joints[0] + joints[[1, 4, 7, 10]].mean(axis=0)) / 2, atol=1e-3
        )
        self.assertEqual(body.names[body.landmark_bones[kb.LANDMARKS.index("ring_tip")]], "finger4-3.R")
        self.assertTrue(np.all(body.is_hand == 1))

    def test_takes_other_joints_and_tips(self):
        names = ["wrist", *(f"{finger}{k}" for finger in kb.FINGERS for k in (1, 2, 3))]
        body = self.converted(
            self.save_npz(shapedirs=None), "--joints", ",".join(names), "--tips", "1,2,3,4,5"
        )
        self.assertEqual(body.names[13], "finger5-1.R")
        self.assertEqual(body.landmark_regressor[kb.LANDMARKS.index("thumb_tip")].vertices.tolist(), [1])
        self.assertEqual(body.shapedirs, [])

    @unittest.skipUnless("KNUCKLE_FRAME_DUMP" in os.environ, "knuckle_frame_dump is not named")
    def test_knuckle_reads_and_renders_it(self):
        self.converted(self.save_npz())
        dump = self.folder / "dump.h5"
        process = subprocess.run(
            [os.environ["KNUCKLE_FRAME_DUMP"], self.out, dump, "--frames", "1"],
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertTrue(dump.exists())

    def test_mirrors_a_left_hand(self):
        body = self.converted(self.save_npz(), "--mirror")
        np.testing.assert_allclose(body.v_template, 1000 * self.model["v_template"] * [-1, 1, 1], atol=1e-4)
        np.testing.assert_array_equal(body.faces, self.model["f"][:, ::-1])

    def test_keeps_the_strongest_four_of_many_bones(self):
        self.model = random_model(bones_per_vertex=9)
        process = run_python(CONVERTER, self.save_npz(), "--out", self.out)
        self.assert_done(process)
        self.assertIn("more than 4 bones lose up to", process.stdout)
        self.assertEqual((kb.dense_weights(knuckle_body_file.read(self.out)) > 0).sum(axis=1).max(), 4)

    def test_refuses_a_pickle_that_calls_something(self):
        touched = self.folder / "touched"
        path = self.save_pickle(self.model | {"v_template": Attack(touched)})
        self.assert_fails(
            run_python(CONVERTER, path, "--out", self.out), path, "system", "refused", output=self.out
        )
        self.assertFalse(touched.exists())

    def test_names_a_damaged_file(self):
        whole = self.save_pickle(as_published(self.model)).read_bytes()
        short = self.folder / "short.pkl"
        for length in (0, 1, 100, len(whole) // 2, len(whole) - 1):
            with self.subTest(length=length):
                short.write_bytes(whole[:length])
                self.assert_fails(
                    run_python(CONVERTER, short, "--out", self.out), short, "no whole pickle", output=self.out
                )
        short_npz = self.folder / "short.npz"
        short_npz.write_bytes(self.save_npz().read_bytes()[:5000])
        self.assert_fails(
            run_python(CONVERTER, short_npz, "--out", self.out), short_npz, "no whole .npz", output=self.out
        )
        self.assert_fails(
            run_python(CONVERTER, self.folder / "none.pkl", "--out", self.out),
            "none.pkl",
            "No such file",
            output=self.out,
        )

    def test_names_the_array_at_fault(self):
        nan_weights, nan_vertex, lost = (
            self.model[name].copy() for name in ("weights", "v_template", "weights")
        )
        nan_weights[9, 3], nan_vertex[4, 1], lost[8] = np.nan, np.nan, 0
        cyclic = np.array([[2**32 - 1, 2, 1, *PARENTS[3:]], range(JOINTS)], np.uint32)
        for changes, part in (
            ({"weights": nan_weights}, "a weight of vertex 9 is not a finite"),
            ({"weights": lost}, "vertex 8 has no weights"),
            ({"v_template": nan_vertex}, "v_template of vertex 4 is not finite"),
            ({"v_template": 1000 * self.model["v_template"]}, "expected metres"),
            ({"kintree_table": cyclic}, "the parent of bone 'finger2-1.R' is 2"),
            ({"J_regressor": 2 * self.model["J_regressor"]}, "J_regressor of wrist sums to 2"),
            ({"J_regressor": None}, "it lacks J_regressor"),
            ({"J_regressor": self.model["J_regressor"].T}, "J_regressor is (778, 16)"),
            ({"f": self.model["f"] + 1}, "faces name vertex 778"),
            ({"shapedirs": np.full((VERTICES, 3, 2), np.inf)}, "'shape_00'"),
            (
                {"weights": np.array(["a"] * VERTICES * JOINTS).reshape(VERTICES, JOINTS)},
                "weights holds <U1, expected numbers",
            ),
        ):
            with self.subTest(part):
                path = self.save_npz(**changes)
                self.assert_fails(run_python(CONVERTER, path, "--out", self.out), path, part, output=self.out)

    def test_names_the_option_at_fault(self):
        path = self.save_npz()
        for options, part in (
            (["--tips", "1,2,3"], "--tips is '1,2,3'"),
            (["--tips", "1,2,3,4,778"], "0 to 777"),
            (["--joints", "wrist"], "--joints names 1"),
            (["--joints", ",".join(map(str, range(16)))], "--joints lacks wrist, thumb1"),
        ):
            with self.subTest(part):
                self.assert_fails(
                    run_python(CONVERTER, path, "--out", self.out, *options), path, part, output=self.out
                )


if __name__ == "__main__":
    unittest.main()
