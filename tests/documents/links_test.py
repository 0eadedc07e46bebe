# SPDX-License-Identifier: Apache-2.0
"""Every link of the documents, and every path of the project that they name, leads to something that exists; the code in
them is in a known language, so that no command hides from the tests of commands."""
import re
import unittest

from documents import PROJECT, documents, headings, parts

LINK = re.compile(r"\]\(([^)\s]+)\)")
# `docs/x.md`, `manifests/demo.toml`, `core/options.h`; placeholders (NAME, *, ...) are no paths.
PATH = re.compile(r"`((?:[a-z_.][\w.-]*/)+[\w.-]+\.(?:md|toml|sh|py|cpp|h|cmake|h5|pt|png))`")
# `synth/sensor/`, as the table of docs/ARCHITECTURE.md says where a change belongs.
FOLDER = re.compile(r"`((?:[a-z_]+/)+)`")
# Made by a command, or a file of the user's or of a data set.
NOT_OURS = re.compile(r"^(report|figures|build|depth|infrared|logs|mask|my_set|samples|share|tables|timings)/")
LANGUAGES = {"sh", "toml", "cpp", "python", "diff", ""}


def folders_of(document):
    """Where a path in backticks may start."""
    return [document.parent, PROJECT, PROJECT / "src/knuckle"]


class LinksTest(unittest.TestCase):
    def test_links_lead_to_files_and_headings(self):
        count = 0
        for document in documents():
            for target in LINK.findall(parts(document)[0]):
                if re.match(r"[a-z]+:", target):
                    continue
                count += 1
                path, _, heading = target.partition("#")
                file = (document.parent / path).resolve() if path else document
                with self.subTest(document=document.name, target=target):
                    self.assertTrue(file.exists(), "there is no such file")
                    self.assertTrue(file.is_relative_to(PROJECT), "it lies outside of the project")
                    if heading:
                        self.assertIn(heading, headings(file))
        self.assertGreater(count, 20)

    def test_named_paths_exist(self):
        count = 0
        for document in documents():
            prose = parts(document)[0]
            for path in PATH.findall(prose) + FOLDER.findall(prose):
                if NOT_OURS.match(path):
                    continue
                count += 1
                with self.subTest(document=document.name, path=path):
                    self.assertTrue(any((folder / path).exists() for folder in folders_of(document)))
        self.assertGreater(count, 10)

    def test_every_document_is_reached_from_the_readme(self):
        seen, new = set(), {PROJECT / "README.md"}
        while new:
            seen |= new
            links = {(page.parent / link.partition("#")[0]).resolve()
                     for page in new for link in LINK.findall(parts(page)[0])}
            new = {link for link in links if link.suffix == ".md" and link.exists()} - seen
        self.assertEqual(set(documents()) - seen, set())

    def test_code_is_in_a_known_language(self):
        for document in documents():
            for block in parts(document)[1]:
                with self.subTest(place=block.place):
                    self.assertIn(block.language, LANGUAGES)


if __name__ == "__main__":
    unittest.main()
