# SPDX-License-Identifier: Apache-2.0
"""Doxygen makes its pages without a warning, and every public type, free function and constant has a text."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

from documents import PROJECT, SKIPPED

# Free functions whose names say all there is; overloads and specialisations are documented where they are first declared.
SPEAK_FOR_THEMSELVES = {"operator==", "operator<<", "operator*"}


def run_doxygen(folder):
    options = (PROJECT / "docs/Doxyfile").read_text(encoding="utf-8") + f"\nOUTPUT_DIRECTORY = {folder}\n"
    result = subprocess.run(["doxygen", "-"], input=options, cwd=PROJECT, capture_output=True, text=True, check=False)
    assert result.returncode == 0 and not result.stderr.strip(), f"doxygen warns:\n{result.stderr}"


def has_text(element):
    return any("".join((element.find(part) if element.find(part) is not None else element).itertext()).strip()
               for part in ("briefdescription", "detaileddescription"))


def place_of(element):
    location = element.find("location")
    return f"{location.get('file')}:{location.get('line')}" if location is not None else "?"


def entities(folder):
    """Name, place and element of every type of the library, and of every function and constant outside of types."""
    for path in folder.glob("xml/*.xml"):
        for compound in xml.parse(path).getroot().iter("compounddef"):
            name = compound.findtext("compoundname")
            if compound.get("kind") in ("class", "struct") and compound.get("prot") == "public" and "@" not in name:
                yield name, compound
            if compound.get("kind") == "namespace" and name.startswith("knuckle"):
                for member in compound.iter("memberdef"):
                    if member.get("kind") in ("function", "variable", "enum"):
                        yield f"{name}::{member.findtext('name')}", member


def undocumented(folder):
    documented, missing = set(), {}
    for name, element in entities(folder):
        if has_text(element):
            documented.add(name)
        else:
            missing[name] = place_of(element)
    assert len(documented) > 200, f"only {len(documented)} documented entities: does Doxygen see the headers?"
    return sorted(f"{place}: {name}" for name, place in missing.items()
                  if name not in documented and name.split("::")[-1] not in SPEAK_FOR_THEMSELVES)


def main():
    if not shutil.which("doxygen"):
        print("skipped: Doxygen is not installed")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        run_doxygen(folder)
        missing = undocumented(pathlib.Path(folder))
    print("\n".join(missing))
    print(f"{len(missing)} public entities without a text")
    return 1 if missing else 0


sys.exit(main())
