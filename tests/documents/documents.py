# SPDX-License-Identifier: Apache-2.0
"""The project's documents: where they lie, and the code in them."""
import dataclasses
import pathlib
import re
import sys

sys.dont_write_bytecode = True

SKIPPED = 77  # CTest's SKIP_RETURN_CODE
PROJECT = pathlib.Path(__file__).resolve().parents[2]


@dataclasses.dataclass
class Block:
    """A fenced block of a document: ```language, text, ```."""

    place: str  # file:line of its first line
    language: str
    text: str


def documents():
    """README.md and its like, then docs/."""
    return sorted(PROJECT.glob("*.md")) + sorted((PROJECT / "docs").glob("*.md"))


def parts(document):
    """The document's text without its fenced blocks (their lines left empty), and the blocks."""
    prose, blocks, block = [], [], None
    for number, line in enumerate(document.read_text(encoding="utf-8").split("\n"), 1):
        prose.append("")
        if not line.startswith("```"):
            if block is None:
                prose[-1] = line
            else:
                block.text += line + "\n"
        elif block is None:
            block = Block(f"{document.relative_to(PROJECT)}:{number + 1}", line[3:].strip(), "")
        else:
            blocks.append(block)
            block = None
    assert block is None, f"{block.place}: the block has no end"
    return "\n".join(prose), blocks


def blocks_of(document, language):
    return [block for block in parts(document)[1] if block.language == language]


def headings(document):
    """The anchors that the document's headings give."""
    found = re.findall(r"^#+ +(.*)$", parts(document)[0], re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in found}
