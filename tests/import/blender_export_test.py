# SPDX-License-Identifier: Apache-2.0
"""The Blender exporter on a hand that the test builds: what Blender itself makes of it, and every fault."""
import unittest

from import_testing import (
    HERE,
    SCRIPTS,
    ImportTest,
    bone_transforms,
    hand_map,
    random_rotations,
    require_blender,
    run_blender,
    shaped,
    skinned,
)

require_blender()

import knuckle_body as kb  # noqa: E402
import knuckle_body_file  # noqa: E402
import numpy as np  # noqa: E402

EXPORTER = SCRIPTS / "export_blender_body.py"
BODY_FROM_WORLD = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])


def body_points(world_points):
    """World [m, z up] to body axes [mm, y up]."""
    return 1000 * np.asarray(world_points) @ BODY_FROM_WORLD.T


def rig_name(name):
    """What blender_model.py calls the bone of that name."""
    if name in ("lowerarm01.R", "wrist.R"):
        return {"lowerarm01.R": "arm", "wrist.R": "hand"}[name]
    finger, joint = name.removeprefix("finger").removesuffix(".R").split("-")
    return f"{kb.FINGERS[int(finger) - 1]}.{joint}"


class BlenderExportTest(ImportTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.map_path = cls.folder / "map.toml"
        cls.map_path.write_text(hand_map())
        models = run_blender(HERE / "blender_model.py", cls.folder)
        assert models.returncode == 0, models.stdout + models.stderr
        cls.model = cls.folder / "plain.blend"
        cls.out = cls.folder / "body.model"
        cls.process = cls.export(cls.model, "--out", cls.out, "--landmarks", cls.map_path)
        cls.body = knuckle_body_file.read(cls.out) if cls.process.returncode == 0 else None

    def setUp(self):
        self.assert_done(self.process)

    @staticmethod
    def export(model, *arguments):
        return run_blender(EXPORTER, *arguments, scene=model)

    def posed_by_blender(self, rotations, shapes):
        """N x V x 3 vertices and N x B x 3 heads in body axes."""
        own = [rig_name(name) for name in self.body.names]
        source, target = self.folder / "poses.npz", self.folder / "posed.npz"
        np.savez(source, names=own, rotations=rotations, shapes=shapes)
        process = run_blender(HERE / "blender_pose.py", source, target, scene=self.model)
        self.assert_done(process)
        posed = np.load(target)
        return body_points(posed["vertices"]), body_points(posed["heads"])

    def heads(self):
        return np.array([group.position(self.body.v_template) for group in self.body.joint_regressor])

    def test_has_the_bones_that_move_something_under_the_generators_names(self):
        self.assert_invariants(self.body)
        self.assertEqual(set(self.body.names), set(kb.generator_bone_names().values()) | {"lowerarm01.R"})
        self.assertEqual(
            self.body.parents[self.body.names.index("wrist.R")], self.body.names.index("lowerarm01.R")
        )

    def test_stands_in_body_axes_in_millimetres(self):
        low, high = self.body.v_template.min(axis=0), self.body.v_template.max(axis=0)
        self.assertGreater((high - low)[1], 350)  # 25 cm of arm, 17.5 cm of hand, hanging
        self.assertLess((high - low)[1], 480)
        self.assertGreater(low[1], 800)  # its wrist is 1.1 m above the floor
        landmark = dict(
            zip(
                kb.LANDMARKS, (group.position(self.body.v_template) for group in self.body.landmark_regressor)
            )
        )
        self.assertLess(landmark["thumb_tip"][0], landmark["little_tip"][0])  # the thumb on the body's right

    def test_faces_look_outwards(self):
        corners = self.body.v_template.astype(np.float64)[self.body.faces]
        volume = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
        self.assertGreater(volume, 0)

    def test_skins_as_blender_does(self):
        random = np.random.default_rng(1)
        rotations = np.array([random_rotations(random, len(self.body.names)) for _ in range(8)])
        rotations[0] = np.eye(3)
        shapes = random.uniform(-1, 1, (8, 2))
        shapes[:4] = 0
        expected, heads = self.posed_by_blender(rotations, shapes)
        worst = worst_head = 0.0
        for pose in range(8):
            transforms = bone_transforms(self.body, self.heads(), rotations[pose])
            points = skinned(self.body, shaped(self.body, shapes[pose]), transforms)
            worst = max(worst, np.linalg.norm(points - expected[pose], axis=1).max())
            own = np.einsum("bij,bj->bi", transforms[:, :3, :3], self.heads()) + transforms[:, :3, 3]
            worst_head = max(worst_head, np.linalg.norm(own - heads[pose], axis=1).max())
        print(f"largest distance from Blender's own mesh {worst:.2e} mm, of bone heads {worst_head:.2e} mm")
        self.assertLess(worst, 1e-3)
        self.assertLess(worst_head, 1e-3)

    def test_shape_keys_are_shape_directions(self):
        identity = np.tile(np.eye(3), (2, len(self.body.names), 1, 1))
        expected, _ = self.posed_by_blender(identity, np.eye(2))
        self.assertEqual([direction.name for direction in self.body.shapedirs], ["longer", "fat"])
        for key in range(2):
            np.testing.assert_allclose(shaped(self.body, np.eye(2)[key]), expected[key], atol=1e-3)
            moved = np.linalg.norm(expected[key] - self.body.v_template, axis=1) > 1e-3
            self.assertEqual(set(np.flatnonzero(moved)) - set(self.body.shapedirs[key].vertices), set())
            self.assertGreater(moved.sum(), 10)

    def test_landmarks_are_where_the_map_says(self):
        heads = dict(zip(self.body.names, self.heads()))
        for landmark, bone in kb.generator_bone_names().items():
            index = kb.LANDMARKS.index(landmark)
            np.testing.assert_allclose(
                self.body.landmark_regressor[index].position(self.body.v_template), heads[bone], atol=1e-3
            )
            self.assertEqual(self.body.names[self.body.landmark_bones[index]], bone)
        palm = self.body.landmark_regressor[kb.LANDMARKS.index("palm")].position(self.body.v_template)
        knuckles = np.mean([heads[f"finger{k}-1.R"] for k in (2, 3, 4, 5)], axis=0)
        np.testing.assert_allclose(palm, (heads["wrist.R"] + knuckles) / 2, atol=1e-3)

    def test_the_hand_begins_at_the_wrist(self):
        heads = dict(zip(self.body.names, self.heads()))
        along = heads["lowerarm01.R"] - heads["wrist.R"]
        centres = self.body.v_template[self.body.faces].mean(axis=1) - heads["wrist.R"]
        height = centres @ along / np.linalg.norm(along)
        self.assertTrue(np.all(self.body.is_hand[height < -30] == 1))
        self.assertTrue(np.all(self.body.is_hand[height > 30] == 0))

    def test_mirrors_a_left_hand(self):
        out = self.folder / "mirrored.model"
        self.assert_done(self.export(self.model, "--out", out, "--landmarks", self.map_path, "--mirror"))
        mirrored = knuckle_body_file.read(out)
        np.testing.assert_allclose(mirrored.v_template, self.body.v_template * [-1, 1, 1], atol=1e-5)
        corners = mirrored.v_template.astype(np.float64)[mirrored.faces]
        self.assertGreater(
            np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum(), 0
        )

    def test_chooses_the_mesh_that_is_named(self):
        out, never = self.folder / "glove.model", self.folder / "never.model"
        model = self.folder / "two_meshes.blend"
        self.assert_done(self.export(model, "--out", out, "--landmarks", self.map_path, "--mesh", "Glove"))
        self.assert_fails(
            self.export(model, "--out", never, "--landmarks", self.map_path),
            model,
            "--mesh",
            "Glove, Hand",
            output=never,
        )
        self.assert_fails(
            self.export(model, "--out", never, "--landmarks", self.map_path, "--mesh", "Sock"),
            "'Sock'",
            "Glove, Hand",
            output=never,
        )

    def test_names_what_a_model_lacks(self):
        for variant, part in (
            ("no_armature", "the file has no armature"),
            ("lost_vertex", "vertex 11 has no weights"),
            ("nan_weight", "a weight of vertex 7 is not a finite number"),
        ):
            with self.subTest(variant):
                model, out = self.folder / f"{variant}.blend", self.folder / "never.model"
                self.assert_fails(
                    self.export(model, "--out", out, "--landmarks", self.map_path), model, part, output=out
                )

    def test_names_the_bone_that_only_the_map_has(self):
        path, out = self.folder / "wrong.toml", self.folder / "never.model"
        path.write_text(hand_map(index_pip="pointer.2 head"))
        self.assert_fails(
            self.export(self.model, "--out", out, "--landmarks", path),
            path,
            "index_pip",
            "'pointer.2'",
            "armature lacks",
            output=out,
        )

    def test_asks_for_a_blend_file(self):
        out = self.folder / "never.model"
        self.assert_fails(self.export(None, "--out", out), "no .blend file was read", output=out)

    def test_asks_for_a_map_where_the_bones_have_other_names(self):
        out = self.folder / "never.model"
        self.assert_fails(
            self.export(self.model, "--out", out), "plain.blend", "--landmarks", "'wrist.R'", output=out
        )


if __name__ == "__main__":
    unittest.main()
