#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What postures are likely, learned from the generator's sampler: writes src/knuckle/hand/posture_table.h.

An adult's skeleton is fitted to the true landmarks of rendered hands, left ones mirrored; the mean and the covariance of its 22
angles are those of the prior over postures (src/knuckle/hand/posture_prior.h). Needs the Python package of this checkout on
PYTHONPATH; takes minutes.

    fit_posture_prior.py [--out FILE] [--most N]
"""
import argparse
from pathlib import Path

import knuckle
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
# Frames of each manifest, 7 apart, so that one person's or place's do not crowd out the others.
FRAMES = {"train_network": 2500, "train_scenes": 1000, "train_held": 700, "train_relaxed": 700}
STRIDE, FIRST = 7, 3
TRUTH_WEIGHT = 400.0  # a deviation of 0.2 mm: the landmarks decide; what they do not show is as the table says that is there
MOST_RMS_MM = 3.0  # a fit that is worse is of another hand than an adult's
# What a person's own joints differ from the sampler's [rad]: widens the distribution where the sampler never moves.
LEAST_SPREAD_RAD = 0.05


def angles_of(frame, skeleton):
    """The angles of each of the frame's right hands, and of its left ones seen in a mirror, that the skeleton fits."""
    for hand in frame.hands or [frame]:
        points = np.array(hand.truth_mm)
        if hand.side == "left":
            points[:, 0] = -points[:, 0]
        fit = skeleton.fit(points, np.full(len(points), TRUTH_WEIGHT))
        if fit is not None and fit.rms_mm <= MOST_RMS_MM:
            yield list(fit.angles_rad.values())


def sampled_angles(most):
    skeleton = knuckle.HandSkeleton.adult()
    rows = []
    for name, count in FRAMES.items():
        for i in range(min(count, most)):
            rows += angles_of(knuckle.render(ROOT / "manifests" / f"{name}.toml", STRIDE * i + FIRST), skeleton)
        print(f"{name}: {len(rows)} hands so far", flush=True)
    return np.array(rows)


def numbers(values):
    return ", ".join(f"{value:.4f}" for value in values)


def table(mean, precision):
    rows = ",\n".join(f"    {{{{{numbers(row[: i + 1])}}}}}" for i, row in enumerate(precision))
    return f"""// SPDX-License-Identifier: Apache-2.0
// Written by scripts/fit_posture_prior.py.
#pragma once

#include <array>

#include "knuckle/hand/hand_angles.h"

namespace knuckle {{

// clang-format off
/// Mean angles [rad], in the order of HandAngle.
inline constexpr std::array<double, kHandAngleCount> kMeanPosture = {{{numbers(mean)}}};
/// The lower triangle of the inverse of their covariance [1/rad^2].
inline constexpr std::array<std::array<double, kHandAngleCount>, kHandAngleCount> kPosturePrecision = {{{{
{rows}}}}};
// clang-format on

}}  // namespace knuckle
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "src/knuckle/hand/posture_table.h")
    parser.add_argument("--most", type=int, default=10**9, help="frames of each manifest")
    arguments = parser.parse_args()
    angles = sampled_angles(arguments.most)
    covariance = np.cov(angles, rowvar=False) + LEAST_SPREAD_RAD**2 * np.eye(angles.shape[1])
    arguments.out.write_text(table(angles.mean(axis=0), np.linalg.inv(covariance)))
    print(f"{len(angles)} hands: {arguments.out}")


if __name__ == "__main__":
    main()
