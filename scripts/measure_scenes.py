#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures anew what docs/results.md says of hands among things where no single command does, in one run (minutes).

    measure_scenes.py [--program build/release/bin/knuckle] [--recordings FOLDER] --out FOLDER

Prints a line per figure: rooms, desks and arms without a hand, two hands; of recordings the sides of hands, also in a
mirror, and what is found where the hand is cut out. FOLDER gets the sets that are made, poses, records and reports.
Recordings: the folder of kinect_gestures, kinect2_hand, table_cam2, table_cam4, table_cam6; without them they are left out.
Needs python3-pil.
"""
import json
import re

import numpy as np
from PIL import Image

from laboratory import ROOT, laboratory_and_recordings

EMPTY = {"rooms": ("validate_scenes", 2000, 0.0), "desks": ("validate_desks", 600, 0.0), "arms that end without a hand": ("validate_scenes", 200, 1.0)}
WAYS = {"side auto": ("default", {}), "side right": ("default", {"side": '"right"'}), "careful": ("careful", {})}
TWO_HANDS = {"all": None, "apart": (0.0, 0.0), "crossing": (1.0, 0.0), "touching": (0.0, 1.0)}  # shares that cross, that touch
CUT_OUT = ("kinect2_hand", "table_cam2", "table_cam4", "table_cam6")
MASK_GROWS_PX = 6
RING_PX = 40  # around the mask, where the plane is fitted that takes the hand's place
NEAR_MM = 10.0  # of the plane, at 1 m


def manifest(lab, name, text):
    path = lab.out / f"{name.replace(' ', '_')}.toml"
    path.write_text(text)
    return f"synthetic:{path}"


def manifest_text(name):
    return (ROOT / "manifests" / f"{name}.toml").read_text()


def records_of(lab, name, source, pipeline):
    _, path, _ = lab.estimated(name, source, pipeline)
    return path, [json.loads(line) for line in path.read_text().splitlines()]


def reported(records):
    return f"{sum(bool(record['hands']) for record in records)} of {len(records)}"


def empty_rooms(lab):
    for name, (base, frames, stumps) in EMPTY.items():
        text = re.sub(r"(?m)^frames = \d+", f"frames = {frames}", manifest_text(base))
        text = re.sub(r"(?m)^(empty_share|cut_share) = .*\n", "", text)
        source = manifest(lab, name, text.replace("[scene]\n", f"[scene]\nempty_share = 1.0\nstump_share = {stumps}\n"))
        for way, (pipeline, keys) in WAYS.items():
            _, records = records_of(lab, f"{name}_{way}".replace(" ", "_"), source, lab.pipeline(pipeline, **keys))
            print(f"{name}, {way}: a hand reported in {reported(records)} frames", flush=True)


def two_hands(lab):
    for name, shares in TWO_HANDS.items():
        text = manifest_text("test_two_hands")
        if shares:
            text = re.sub(r"(?m)^(crossed|touching)_share = .*\n", "", text)
            text += f"crossed_share = {shares[0]}\ntouching_share = {shares[1]}\n"
        source = manifest(lab, f"two_{name}", text)
        for way, pipeline in (("followed", lab.pipeline("track_both")), ("frame by frame", lab.pipeline("default", max_hands=2))):
            run = f"two_{name}_{way}".replace(" ", "_")
            path, _ = records_of(lab, run, source, pipeline)
            hands = lab.scored(run, source, records=path)[0]["followed"][0]
            print(f"two hands, {name}, {way}: " + ", ".join(f"{key} {value}" for key, value in hands.items() if isinstance(value, int)), flush=True)


def sides(lab, folder):
    source = folder / "kinect_gestures"
    mirror = lab.out / "mirror"
    description = (source / "dataset.toml").read_text()
    width, cx = (int(re.search(rf"(?m)^{key} = (\d+)", description)[1]) for key in ("width", "cx"))
    write_set(source, mirror, description.replace(f"cx = {cx}", f"cx = {width - 1 - cx}"), lambda depth, _: depth[:, ::-1])
    for name, path, side in (("gestures", source, "right"), ("gestures in a mirror", mirror, "left")):
        _, records = records_of(lab, name.replace(" ", "_"), f"folder:{path}", lab.pipeline("default"))
        seen = [record["hands"][0]["side"] for record in records if record["hands"]]
        print(f"{name}: {seen.count(side)} of {len(seen)} hands found are {side}", flush=True)


def write_set(source, path, description, change):
    """A folder set with other depths; `change` is given each image [mm] and its file's name."""
    (path / "depth").mkdir(parents=True, exist_ok=True)
    (path / "dataset.toml").write_text(description)
    for file in sorted((source / "depth").iterdir()):
        depth = np.array(Image.open(file)).astype(np.uint16)
        Image.fromarray(np.ascontiguousarray(change(depth, file.name))).save(path / "depth" / file.name)


def grown(mask, pixels):
    for _ in range(pixels):
        before = mask.copy()
        mask = before.copy()
        mask[1:] |= before[:-1]
        mask[:-1] |= before[1:]
        mask[:, 1:] |= before[:, :-1]
        mask[:, :-1] |= before[:, 1:]
    return mask


def plane_around(depth, mask):
    """The inverse depth of the plane that most of what surrounds the mask lies near to, as a function of the pixel."""
    rows, columns = np.nonzero(grown(mask, RING_PX) & ~mask & (depth > 0))
    inverse = 1.0 / depth[rows, columns]
    pixels = np.stack([columns, rows, np.ones_like(rows)], 1).astype(float)
    near = np.zeros(len(inverse), bool)
    random = np.random.default_rng(1)
    for _ in range(200):
        three = random.choice(len(inverse), 3, replace=False)
        if abs(np.linalg.det(pixels[three])) < 1.0:
            continue
        plane = np.linalg.solve(pixels[three], inverse[three])
        fits = np.abs(pixels @ plane - inverse) * 1000.0 < NEAR_MM * inverse  # farther away noise is larger
        if fits.sum() > near.sum():
            near = fits
    plane = np.linalg.lstsq(pixels[near], inverse[near], rcond=None)[0]
    return lambda columns, rows: plane[0] * columns + plane[1] * rows + plane[2]


def hands_cut_out(lab, folder):
    for name in CUT_OUT:
        source = folder / name

        def cut(depth, file):
            mask = grown(np.array(Image.open(source / "mask" / file)) > 0, MASK_GROWS_PX)
            if name == "kinect2_hand":  # before nothing
                depth[mask] = 0
            else:
                rows, columns = np.nonzero(mask)
                inverse = np.maximum(plane_around(depth, mask)(columns, rows), 1e-4)
                depth[rows, columns] = np.round(1.0 / inverse)
            return depth

        path = lab.out / f"without_{name}"
        description = re.sub(r"(?m)^convention = .*\n", "", (source / "dataset.toml").read_text())
        write_set(source, path, description, cut)
        for pipeline in ("default", "careful"):
            _, records = records_of(lab, f"without_{name}_{pipeline}", f"folder:{path}", lab.pipeline(pipeline))
            print(f"{name} with the hand cut out, {pipeline}: a hand reported in {reported(records)} frames", flush=True)


def main():
    lab, folder = laboratory_and_recordings(__doc__.splitlines()[0])
    if folder:
        sides(lab, folder)
        hands_cut_out(lab, folder)
    two_hands(lab)
    empty_rooms(lab)


if __name__ == "__main__":
    main()
