# SPDX-License-Identifier: Apache-2.0
"""What the importers do without Blender: weights, points as vertex groups, the file, landmark maps."""
import unittest

from import_testing import SCRIPTS, ImportTest, hand_map

import knuckle_body as kb
import knuckle_body_file
import knuckle_landmark_map as lm
import numpy as np


def ring(radius, height, count=12):
    angles = 2 * np.pi * np.arange(count) / count
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(count, height)], axis=1)


def small_body():
    """Two bones along z in a tube of three rings."""
    vertices = np.concatenate([ring(8, height) for height in (0, 20, 40)]).astype(np.float32)
    faces = [[a, b, 12 + a] for a, b in zip(range(12), [*range(1, 12), 0])]
    bones, weights, _ = kb.strongest_weights(np.repeat([[1, 0], [0.5, 0.5], [0, 1]], 12, axis=0))
    groups = [kb.point_as_group(np.array([0, 0, height]), vertices, np.arange(36)) for height in (0, 20)]
    offsets = np.zeros((36, 3))
    offsets[24:, 2] = 5
    return kb.Body(
        vertices,
        np.array(faces, np.int32),
        np.ones(12, np.uint8),
        bones,
        weights,
        ["root", "tip"],
        np.array([-1, 0], np.int32),
        groups,
        [groups[1]] * 22,
        np.ones(22, np.int32),
        [kb.sparse_direction("longer", offsets)],
    )


class WeightsTest(ImportTest):
    def test_keeps_the_strongest_four(self):
        dense = np.array([[0.1, 0.3, 0.0, 0.2, 0.25, 0.15], [0, 0, 2.0, 0, 0, 0]])
        bones, weights, dropped = kb.strongest_weights(dense)
        self.assertEqual(bones.tolist(), [[1, 4, 3, 5], [2, 0, 0, 0]])
        np.testing.assert_allclose(weights, [np.array([0.3, 0.25, 0.2, 0.15]) / 0.9, [1, 0, 0, 0]], rtol=1e-6)
        self.assertAlmostEqual(dropped, 0.1)

    def test_names_the_vertex_at_fault(self):
        for value, part in (
            (np.nan, "vertex 1 is not a finite"),
            (np.inf, "vertex 1 is not a finite"),
            (-0.1, "vertex 1 is negative"),
            (0.0, "vertex 1 has no weights"),
        ):
            with self.assertRaisesRegex(kb.BodyError, part):
                kb.strongest_weights([[0.5, 0.5], [0, value], [1, 0]])


class GroupTest(ImportTest):
    def test_reproduces_points_inside_and_outside_of_the_mesh(self):
        random = np.random.default_rng(3)
        vertices = np.concatenate([ring(9 - 0.1 * h, h) for h in range(0, 60, 6)]) + [700, 1400, 100]
        for point in random.uniform([692, 1392, 95], [708, 1408, 165], (50, 3)):
            group = kb.point_as_group(point, vertices.astype(np.float32), np.arange(len(vertices)))
            np.testing.assert_allclose(group.position(vertices.astype(np.float32)), point, atol=1e-3)
            self.assertAlmostEqual(float(group.weights.sum()), 1, places=5)

    def test_a_point_on_the_axis_is_a_mean_without_negative_weights(self):
        vertices = np.concatenate([ring(9, h) for h in range(0, 60, 6)])
        group = kb.point_as_group(np.array([1.0, -2.0, 31.0]), vertices, np.arange(len(vertices)))
        self.assertGreaterEqual(group.weights.min(), 0)

    def test_a_flat_mesh_has_no_points_off_its_plane(self):
        with self.assertRaisesRegex(kb.BodyError, "one plane"):
            kb.point_as_group(np.array([0, 0, 1.0]), ring(5, 0), np.arange(12))


class FileTest(ImportTest):
    def test_reads_back_what_it_writes(self):
        body, path = small_body(), self.folder / "body.model"
        knuckle_body_file.write(body, path)
        again = knuckle_body_file.read(path)
        for name in (
            "v_template",
            "faces",
            "is_hand",
            "weights",
            "weight_bones",
            "parents",
            "landmark_bones",
        ):
            np.testing.assert_array_equal(getattr(again, name), getattr(body, name), err_msg=name)
        self.assertEqual(again.names, body.names)
        self.assertEqual(again.shapedirs[0].name, "longer")
        np.testing.assert_array_equal(again.shapedirs[0].vertices, np.arange(24, 36))
        np.testing.assert_array_equal(again.shapedirs[0].offsets_mm, body.shapedirs[0].offsets_mm)
        for mine, yours in zip(again.joint_regressor, body.joint_regressor):
            np.testing.assert_array_equal(mine.weights, yours.weights)

    def test_writes_no_file_of_a_faulty_body(self):
        path = self.folder / "never.model"
        for change, part in (
            ({"v_template": small_body().v_template * np.nan}, "v_template of vertex 0"),
            ({"weights": small_body().weights * 0.5}, "weights of vertex 0 sum to 0.5"),
            ({"parents": np.array([1, 0])}, "the parent of bone 'root' is 1"),
            ({"names": ["a", "a"]}, "different names"),
            ({"faces": np.array([[0, 1, 36]])}, "faces name vertex 36"),
        ):
            body = small_body()
            for name, value in change.items():
                setattr(body, name, value)
            with self.subTest(part), self.assertRaisesRegex(kb.BodyError, part):
                knuckle_body_file.write(body, path)
            self.assertFalse(path.exists())

    def test_says_where_it_cannot_write(self):
        with self.assertRaisesRegex(kb.BodyError, "nowhere"):
            knuckle_body_file.write(small_body(), self.folder / "nowhere" / "body.model")


class LandmarkMapTest(ImportTest):
    def read(self, text):
        path = self.folder / "map.toml"
        path.write_text(text)
        return lm.read_landmark_map(path)

    def test_reads_points_and_new_names(self):
        mapped = self.read(hand_map())
        self.assertEqual(mapped.points["thumb_tip"], [lm.BonePoint("thumb.3", "tail")])
        self.assertEqual(mapped.renamed["index.2"], "finger2-2.R")
        self.assertEqual(mapped.renamed["arm"], "lowerarm01.R")
        self.assertNotIn("palm", mapped.points)

    def test_names_file_and_fault(self):
        for text, part in (
            (hand_map(ring_tip=None), "no bone for ring_tip"),
            (hand_map(ring_tip="ring.3 middle"), "ring_tip is 'ring.3 middle', expected 'BONE head'"),
            (hand_map(ring_tip="tail"), "ring_tip is 'tail'"),
            (hand_map(toe="ring.3 tail"), "unknown landmark 'toe'"),
            (hand_map() + "[feet]\n", "unknown key 'feet'"),
            ("[landmarks", "Expected"),
        ):
            with self.subTest(part), self.assertRaisesRegex(kb.BodyError, f"map.toml: .*{part}"):
                self.read(text)
        with self.assertRaisesRegex(kb.BodyError, "none.toml: cannot be read"):
            lm.read_landmark_map(self.folder / "none.toml")

    def test_the_shipped_maps_are_whole(self):
        paths = sorted((SCRIPTS / "landmarks").glob("*.toml"))
        self.assertGreaterEqual(len(paths), 2)
        for path in paths:
            mapped = lm.read_landmark_map(path)
            hand = set(kb.generator_bone_names().values())
            self.assertLessEqual(hand, set(mapped.renamed.values()), path)
            self.assertEqual(len(set(mapped.renamed.values())), len(mapped.renamed), path)


if __name__ == "__main__":
    unittest.main()
