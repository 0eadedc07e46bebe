#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures anew what docs/tracking.md and docs/hand-model.md say of hands that are followed, in one run (minutes).

    measure_tracking.py [--program build/release/bin/knuckle] [--recordings FOLDER] --out FOLDER

Prints a line per figure. FOLDER gets the sets that are made (sequences with dropped frames, a hand that leaves), poses,
records, reports, and a strip of each sequence. Recordings: the folder of rgbd_sequence, table_cam2, table_cam4, table_cam6;
without them they are left out. For the times nothing else should run. Needs python3-h5py.
"""
import json
import statistics

import h5py
import numpy as np

from laboratory import ROOT, laboratory_and_recordings

SEQUENCES = ("creative", "pico", "kinect_v2")
SENSORS = ("creative", "pico", "kinect_v2", "d400")
RECORDINGS = ("rgbd_sequence", "table_cam2", "table_cam4", "table_cam6")
SINGLE, FOLLOWED, BOTH = "default", "track", "track_both"
DROPPED = 0.3
AWAY, STAYS, TIMES = 15, 25, 10  # frames without and with a hand that leaves and comes back so often
LEARNING = 90  # frames in which a person's hand is learned
FIST = range(3, 11)  # frames of rgbd_sequence


def copied(source, path, frames, change=lambda depth: depth):
    """Some frames of an .h5 set, as another one."""
    with h5py.File(source) as old, h5py.File(path, "w") as new:
        for key, value in old.attrs.items():
            new.attrs.create(key, value, dtype=old.attrs.get_id(key).dtype)
        new.attrs["version"] = np.array(2, old.attrs["version"].dtype)  # the last without sums of the frames
        for key, data in old.items():
            if key == "frame_sums":
                continue
            values = data[:][frames]
            new.create_dataset(key, data=change(values) if key == "depth" else values)
            for name, value in data.attrs.items():
                new[key].attrs[name] = value
    return path


def sequences(lab):
    for name in SEQUENCES:
        source = f"h5:{lab.rendered(name, ROOT / f'manifests/test_{name}.toml')}"
        poses, _, _ = lab.estimated(f"single_{name}", source, lab.pipeline(SINGLE))
        single = lab.scored(f"single_{name}", source, poses)[0]["methods"][0]
        for smoothing in ("none", "one_euro", "kalman"):
            run = f"{smoothing}_{name}"
            poses, records, _ = lab.estimated(run, source, lab.pipeline(FOLLOWED, smoothing=f'"{smoothing}"'))
            scores = lab.scored(run, source, poses, records, strip=smoothing == "kalman")[0]
            method, motion, ids = scores["methods"][0], scores["methods"][0]["motion"], scores["followed"][0]
            print(f"{name}: single {single['mean_3d_mm']:.2f} mm; {smoothing} {method['mean_3d_mm']:.2f} mm, acceleration "
                  f"{motion['acceleration_mm']:.2f} (truth {motion['true_acceleration_mm']:.2f}), lag {motion['lag_frames']:.2f}, "
                  f"bones {100 * motion['bone_deviation']:.1f} %, exchanged ids {ids['switches']}, losses {ids['losses']}")  # fmt: skip


def dropped_frames(lab):
    for name in SEQUENCES:
        source = lab.out / f"{name}.h5"
        with h5py.File(source) as file:
            count = len(file["depth"])
        for draw in (1, 2):
            kept = np.sort(np.random.default_rng(draw).permutation(count)[: round(count * (1 - DROPPED))])
            run = f"dropped{draw}_{name}"
            fewer = f"h5:{copied(source, lab.out / f'{run}.h5', kept)}"
            poses, _, _ = lab.estimated(run, fewer, lab.pipeline(FOLLOWED))
            mean = lab.scored(run, fewer, poses)[0]["methods"][0]["mean_3d_mm"]
            print(f"{name}, draw {draw}: {count - len(kept)} of {count} frames dropped: {mean:.2f} mm")


def in_camera(poses, set_path):
    """Landmarks of a poses file in camera coordinates, frames x landmarks x 3 [mm]."""
    u, v, depth = np.moveaxis(np.loadtxt(poses).reshape(-1, 22, 3), -1, 0)
    with h5py.File(set_path) as file:
        fx, fy, cx, cy = file["intrinsics"][:].T[:, :, None]
    return np.stack([(u - cx) * depth / fx, (v - cy) * depth / fy, depth], -1)


def deviations(points):
    """Of each landmark around its mean place [mm]."""
    return np.sqrt(((points - points.mean(0)) ** 2).sum(-1).mean(0))


def still_hands(lab):
    text = (ROOT / "manifests/test_still.toml").read_text()
    for sensor in SENSORS:
        changed = text.replace('preset = "creative"', f'preset = "{sensor}"')
        if sensor == "kinect_v2":  # it measures nothing that is nearer
            changed = changed.replace("nearest_mm = 350.0", "nearest_mm = 600.0").replace("farthest_mm = 500.0", "farthest_mm = 800.0")
        path = lab.rendered(f"still_{sensor}", text=changed)
        source = f"h5:{path}"
        for smoothing in ("none", "one_euro", "kalman"):
            run = f"still_{smoothing}_{sensor}"
            poses, _, _ = lab.estimated(run, source, lab.pipeline(FOLLOWED, smoothing=f'"{smoothing}"'))
            motion = lab.scored(run, source, poses)[0]["methods"][0]["motion"]
            learned = deviations(in_camera(poses, path)[LEARNING:])
            print(f"still before {sensor}, {smoothing}: {motion['jitter_mm']:.2f} mm, worst landmark {motion['worst_jitter_mm']:.2f}; "
                  f"once the person is known {learned.mean():.2f}, {learned.max():.2f}")  # fmt: skip


def leaving_hand(lab):
    """Frames after each return until the hand is reported."""
    source = lab.out / "creative.h5"
    length = AWAY + STAYS
    frames = np.arange(length * TIMES)

    def leave(depth):
        depth[frames % length < AWAY] = 0
        return depth

    gone = f"h5:{copied(source, lab.out / 'leaving.h5', frames, leave)}"
    poses, _, _ = lab.estimated("leaving", gone, lab.pipeline(FOLLOWED))
    reported = [not line.startswith("nan") for line in poses.read_text().splitlines() if not line.startswith("#")]
    waits = [reported[start + AWAY : start + length].index(True) for start in range(0, len(reported), length)]
    while_away = sum(reported[i] for i in frames if i % length < AWAY)
    print(f"a hand that comes back: found {waits} frames after its return; reported {while_away} times while away")


def two_hands(lab):
    source = f"synthetic:{ROOT}/manifests/test_two_hands.toml"
    poses, records, _ = lab.estimated("two_hands", source, ROOT / f"pipelines/{BOTH}.toml")
    hands = lab.scored("two_hands", source, None, records)[0]["followed"][0]
    print("two hands: " + ", ".join(f"{key} {hands[key]:.4g}" for key in hands if isinstance(hands[key], (int, float))))


def hidden_landmarks(lab):
    source = f"synthetic:{ROOT}/manifests/test_scenes.toml"
    for name, refine in (("joints alone", False), ("hand_model", True)):
        run = f"scenes_{refine}"
        pipeline = lab.pipeline(SINGLE, side='"auto"', refine=refine)
        poses, records, _ = lab.estimated(run, source, pipeline)
        scores = lab.scored(run, source, poses, records)[0]
        behind = scores["followed"][0]["occluders"]
        hidden = [behind[key] for key in behind if key not in ("none", "border")]
        joints = sum(part["joints"] for part in hidden)
        mean = sum(part["joints"] * part["mean_3d_mm"] for part in hidden) / joints
        print(f"test_scenes, {name}: {scores['methods'][0]['mean_3d_mm']:.2f} mm; {behind['none']['joints']} visible landmarks "
              f"{behind['none']['mean_3d_mm']:.2f}, {joints} hidden ones {mean:.2f}")  # fmt: skip


def recordings(lab, folder):
    for name in RECORDINGS:
        source = f"folder:{folder / name}"
        line = [name + ":"]
        for kind, pipeline in (("single", SINGLE), ("followed", FOLLOWED)):
            poses, records, _ = lab.estimated(f"{kind}_{name}", source, lab.pipeline(pipeline))
            _, errors = lab.scored(f"{kind}_{name}", source, poses, strip=kind == "followed")
            ids = {hand["id"] for record in map(json.loads, records.read_text().splitlines()) for hand in record["hands"] if "id" in hand}
            line.append(f"{kind} {len(errors)} frames, {statistics.mean(errors.values()):.2f} mm")
            if name == "rgbd_sequence":
                line.append(f"fist {statistics.mean(errors[i] for i in FIST):.2f} mm")
            if ids:
                line.append(f"ids {sorted(ids)}")
        print(" ".join(line))


def times(lab):
    source = f"h5:{lab.out / 'creative.h5'}"
    ways = {"joints alone": lab.pipeline(SINGLE, refine=False), "hand_model": lab.pipeline(SINGLE), "followed": lab.pipeline(FOLLOWED)}
    took = {way: [] for way in ways}
    for _ in range(5):
        for way, pipeline in ways.items():
            took[way].append(lab.estimated("times", source, pipeline, "--threads", 1)[2])
    print("one core, medians of 5 medians: " + ", ".join(f"{way} {statistics.median(took[way]):.2f} ms" for way in ways))


def main():
    lab, folder = laboratory_and_recordings(__doc__.splitlines()[0])
    sequences(lab)
    times(lab)
    dropped_frames(lab)
    still_hands(lab)
    leaving_hand(lab)
    two_hands(lab)
    hidden_landmarks(lab)
    if folder:
        recordings(lab, folder)


if __name__ == "__main__":
    main()
