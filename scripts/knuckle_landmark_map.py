# SPDX-License-Identifier: Apache-2.0
"""Where a rig has Knuckle's landmarks: a TOML file of bones, each with `head` or `tail` (docs/import.md)."""
import dataclasses
import tomllib

from knuckle_body import LANDMARKS, fail, generator_bone_names


@dataclasses.dataclass(frozen=True)
class BonePoint:
    bone: str
    end: str  # head | tail


@dataclasses.dataclass
class LandmarkMap:
    points: dict  # landmark -> list of BonePoints, whose mean it is; `palm` may be missing
    renamed: dict  # the rig's bone -> its name in the body

    def bones(self):
        return {point.bone for points in self.points.values() for point in points} | set(self.renamed)


def makehuman_map():
    """The map of a rig with MakeHuman's names: wrist.R, finger1-1.R (thumb) to finger5-3.R."""
    points = {landmark: [BonePoint(bone, "head")] for landmark, bone in generator_bone_names().items()}
    for number, finger in enumerate(("thumb", "index", "middle", "ring", "little"), start=1):
        points[f"{finger}_tip"] = [BonePoint(f"finger{number}-3.R", "tail")]
    return LandmarkMap(points, {})


def bone_point(path, landmark, text):
    bone, _, end = str(text).rpartition(" ")
    if end not in ("head", "tail") or not bone:
        fail(f"{path}: {landmark} is '{text}', expected 'BONE head' or 'BONE tail'")
    return BonePoint(bone, end)


def read_landmark_map(path):
    try:
        with open(path, "rb") as file:
            table = tomllib.load(file)
    except OSError as error:
        fail(f"{path}: cannot be read: {error.strerror}")
    except tomllib.TOMLDecodeError as error:
        fail(f"{path}: {error}")
    for key in table:
        if key not in ("landmarks", "bones"):
            fail(f"{path}: unknown key '{key}', known are: landmarks, bones")
    landmarks = table.get("landmarks", {})
    for name in landmarks:
        if name not in LANDMARKS:
            fail(f"{path}: unknown landmark '{name}', known are: {', '.join(LANDMARKS)}")
    missing = [name for name in LANDMARKS if name not in landmarks and name != "palm"]
    if missing:
        fail(f"{path}: no bone for {', '.join(missing)}")
    points = {
        name: [bone_point(path, name, text) for text in (value if isinstance(value, list) else [value])]
        for name, value in landmarks.items()
    }
    return LandmarkMap(points, new_names(points, table.get("bones", {})))


def new_names(points, bones):
    """The bones whose heads are joints of the hand take the names that the generator's poses ask for."""
    renamed = {}
    for landmark, name in generator_bone_names().items():
        if len(points[landmark]) == 1 and points[landmark][0].end == "head":
            renamed[points[landmark][0].bone] = name
    return renamed | {old: new for new, old in bones.items()}


def check_bones(landmark_map, path, known):
    """Fails where the map names a bone that the rig lacks."""
    for landmark, points in landmark_map.points.items():
        for point in points:
            if point.bone not in known:
                fail(
                    f"{path}: {landmark} names the bone '{point.bone}', which the armature lacks; "
                    f"it has: {', '.join(sorted(known))}"
                )
    for bone in landmark_map.renamed:
        if bone not in known:
            fail(f"{path}: [bones] names the bone '{bone}', which the armature lacks")
