# SPDX-License-Identifier: Apache-2.0
"""The notebooks of examples/notebooks run as they stand, but for fewer frames; figures are drawn nowhere."""

import contextlib
import importlib.util
import io
import json
import os
import pathlib
import subprocess
import tempfile
import unittest
import warnings

from testing import DEMO, PROJECT, demo_frames, program

os.environ["MPLBACKEND"] = "Agg"
NOTEBOOKS = PROJECT / "examples/notebooks"


def cells_of(name, kind):
    cells = json.loads((NOTEBOOKS / name).read_text())["cells"]
    return ["".join(cell["source"]) for cell in cells if cell["cell_type"] == kind]


class Notebooks(unittest.TestCase):
    def setUp(self):
        demo_frames()
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(scratch.name)

    def run_notebook(self, name, *changes, needs=("matplotlib",)):
        """What its cells print, and the names that they leave."""
        for module in needs:
            if importlib.util.find_spec(module) is None:
                self.skipTest(f"{module} is missing")
        code = "\n".join(cells_of(name, "code"))
        for old, new in changes:
            self.assertIn(old, code)
            code = code.replace(old, new)
        names = {}
        with contextlib.redirect_stdout(io.StringIO()) as output, warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # Agg has no window to show
            exec(compile(code, name, "exec"), names)  # pylint: disable=exec-used
        return output.getvalue(), names

    def test_each_is_tested_and_has_no_outputs(self):
        self.assertEqual(sorted(path.name for path in NOTEBOOKS.glob("*.ipynb")),
                         ["compare_methods.ipynb", "estimate_a_folder.ipynb", "train_a_network.ipynb"])
        for path in NOTEBOOKS.glob("*.ipynb"):
            notebook = json.loads(path.read_text())
            self.assertEqual((notebook["nbformat"], notebook["nbformat_minor"]), (4, 5))
            for cell in notebook["cells"]:
                self.assertFalse(cell.get("outputs"), path.name)
            self.assertIn("SPDX-License-Identifier", cells_of(path.name, "code")[0])

    def test_estimate_a_folder(self):
        subprocess.run([program(), "render", "--manifest", DEMO, "--count", "9", "--format", "folder", "--out", "my_set"], check=True,
                       capture_output=True)
        output, names = self.run_notebook("estimate_a_folder.ipynb",
                                          ('f"synthetic:{knuckle.data_file(\'manifests/demo.toml\')}"', '"folder:my_set"'))
        self.assertIn("9 frames", output)
        self.assertIn("a hand in 9 of 9 frames", output)
        records = [json.loads(line) for line in pathlib.Path("records.jsonl").read_text().splitlines()]
        self.assertEqual([record["frame"] for record in records], list(range(9)))
        lines = names["rows"].flat[0].lines
        self.assertEqual([len(line.get_xdata()) for line in lines], [5, 5, 5, 5, 5])

    def test_train_a_network(self):
        output, names = self.run_notebook("train_a_network.ipynb", ("FRAMES = 1500", "FRAMES = 128"), ("EPOCHS = 8", "EPOCHS = 6"),
                                          ('f"synthetic:{TEST}"', 'f"synthetic:{TEST}?count=6"'), needs=("matplotlib", "torch"))
        self.assertEqual(names["rendered"].num_workers, 2)
        for number in (0, 77, 127):  # the workers' frames, in order
            for kept, again in zip(names["samples"][number], names["RenderedHands"]()[number]):
                self.assertTrue(kept.equal(again))
        losses = names["losses"]
        self.assertLess(sum(losses[-4:]), 0.7 * sum(losses[:4]))
        self.assertRegex(output, r"mine: \d+\.\d mm\ndefault: \d+\.\d mm\n")
        self.assertGreater(names["scores"]["methods"][0]["mean_3d_mm"], 0)

    def test_compare_methods(self):
        output, names = self.run_notebook("compare_methods.ipynb", ("?count=60", "?count=12"))
        self.assertRegex(output, r"default less free hand: -?\d+\.\d\d mm \(95 %: -?\d+\.\d\d to -?\d+\.\d\d\), p = [01]\.\d{3}")
        self.assertEqual([method["name"] for method in names["scores"]["methods"]], ["default", "free hand"])


if __name__ == "__main__":
    unittest.main()
