#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Trains a small network in PyTorch on frames of `knuckle render`, and exports it with PyTorch's own exporter: an example of a
network that Knuckle knows nothing of. hand.toml says what it wants and gives.

    knuckle render --manifest manifests/train_network.toml --count 12000 --out train.h5
    python3 examples/foreign_network/train.py train.h5 hand.onnx --minutes 10

Needs python3-torch and python3-h5py. It sees 64 x 64 pixels of a cube of 300 mm: 1 at its near end, 0 at its far end and
where nothing is; and gives x, y, z of 21 landmarks from the cube's centre, in halves of its side, y pointing up.
"""
import argparse
import time

import h5py
import numpy
import torch
from torch import nn

SIZE = 64
SIDE_MM = 300.0
FINGERS = ("thumb", "index", "middle", "ring", "little")
LEVELS = (("cmc", "mcp"), ("mcp", "pip"), ("ip", "dip"), ("tip", "tip"))  # of the thumb, and of the others
# Level by level, an order of its own.
ORDER = ["wrist"] + [
    f"{finger}_{thumb if finger == 'thumb' else other}" for thumb, other in LEVELS for finger in FINGERS
]


class HandNet(nn.Module):
    def __init__(self):
        super().__init__()

        def block(inputs, outputs, kernel):
            return [
                nn.Conv2d(inputs, outputs, kernel, stride=2, padding=kernel // 2, bias=False),
                nn.BatchNorm2d(outputs),
                nn.ReLU6(),
            ]

        self.features = nn.Sequential(*block(1, 16, 5), *block(16, 32, 3), *block(32, 64, 3), *block(64, 64, 3))
        self.head = nn.Sequential(
            nn.Flatten(), nn.Linear(64 * 4 * 4, 96), nn.ReLU(), nn.Dropout(0.1), nn.Linear(96, 3 * len(ORDER))
        )

    def forward(self, depth):
        return self.head(self.features(depth))


def cut(depth_mm, camera, centre):
    """The cube around a point in camera coordinates [mm], as 64 x 64 values from 1 (near) to 0 (far, or nothing)."""
    fx, fy, cx, cy = camera
    place = numpy.arange(SIZE) - 0.5 * (SIZE - 1)
    scale = fx * SIDE_MM / centre[2] / SIZE
    columns = numpy.floor(centre[0] / centre[2] * fx + cx + place * scale + 0.5).astype(int)
    rows = numpy.floor(centre[1] / centre[2] * fy + cy + place * scale + 0.5).astype(int)
    inside = ((rows >= 0) & (rows < depth_mm.shape[0]))[:, None] & ((columns >= 0) & (columns < depth_mm.shape[1]))
    pixels = depth_mm[rows.clip(0, depth_mm.shape[0] - 1)[:, None], columns.clip(0, depth_mm.shape[1] - 1)]
    near = 0.5 - (pixels - centre[2]) / SIDE_MM
    return numpy.where(inside & (pixels > 0) & (near > 0) & (near < 1), near, 0).astype(numpy.float32)


class Samples:
    def __init__(self, path):
        with h5py.File(path) as file:
            self.depth = file["depth"][:]
            self.unit = float(file.attrs["depth_unit_mm"])
            self.cameras = file["intrinsics"][:]
            names = file.attrs["landmarks"].decode().split(", ")
            self.joints = file["joints_mm"][:][:, [names.index(name) for name in ORDER]].astype(numpy.float64)
            centres = file["joints_mm"][:].astype(numpy.float64)
        self.centres = numpy.nanmean(centres, axis=1)
        self.sound = numpy.flatnonzero(numpy.isfinite(self.joints).all(axis=(1, 2)))

    def batch(self, indices, random, jitter_mm=12.0):
        patches, targets = [], []
        for i in indices:
            centre = self.centres[i] + random.uniform(-jitter_mm, jitter_mm, 3)
            patches.append(cut(self.depth[i] * self.unit, self.cameras[i], centre))
            offsets = (self.joints[i] - centre) / (0.5 * SIDE_MM)
            targets.append((offsets * [1, -1, 1]).ravel())
        return torch.from_numpy(numpy.stack(patches)[:, None]), torch.tensor(numpy.stack(targets), dtype=torch.float32)


def error_mm(network, samples, indices):
    network.eval()
    with torch.no_grad():
        patches, targets = samples.batch(indices, numpy.random.default_rng(0))
        offsets = (network(patches) - targets).reshape(len(indices), -1, 3) * 0.5 * SIDE_MM
    network.train()
    return offsets.norm(dim=2).mean().item()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("samples", help="an .h5 file of `knuckle render`")
    parser.add_argument("out", help="ONNX file to write")
    parser.add_argument("--minutes", type=float, default=10.0)
    arguments = parser.parse_args()
    torch.manual_seed(1)
    torch.set_num_threads(1)
    random = numpy.random.default_rng(1)
    samples = Samples(arguments.samples)
    validation, training = samples.sound[:400], samples.sound[400:]
    network = HandNet()
    optimiser = torch.optim.AdamW(network.parameters(), lr=2e-3, weight_decay=1e-2)
    begin = time.monotonic()
    done = step = 0
    while done < 1:
        done = (time.monotonic() - begin) / (60 * arguments.minutes)
        for group in optimiser.param_groups:
            group["lr"] = 2e-3 * max(1e-3, 0.5 * (1 + numpy.cos(numpy.pi * min(done, 1))))
        patches, targets = samples.batch(random.choice(training, 64, replace=False), random)
        optimiser.zero_grad()
        nn.functional.smooth_l1_loss(network(patches), targets, beta=0.05).backward()
        optimiser.step()
        step += 1
        if step % 500 == 0:
            print(f"{step} steps, {error_mm(network, samples, validation):.1f} mm", flush=True)
    print(f"{step} steps, {error_mm(network, samples, validation):.1f} mm")
    network.eval()
    torch.onnx.export(network, torch.zeros(1, 1, SIZE, SIZE), arguments.out, opset_version=11,
                      input_names=["depth"], output_names=["xyz"])


if __name__ == "__main__":
    main()
