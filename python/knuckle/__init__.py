# SPDX-License-Identifier: Apache-2.0
"""Hand pose from depth images.

    import knuckle

    pipeline = knuckle.Pipeline.default()
    for frame in knuckle.open_source("folder:my_set"):
        for hand in pipeline.estimate(frame.depth_mm, frame.camera).hands:
            print(frame.name, hand.side, hand.score, hand.landmarks_mm)

Lengths are millimetres, times seconds, angles radians. Camera coordinates: x right, y down, z forward. Image coordinates:
column and row [px], the centre of the first pixel is (0, 0), whatever a source's own files count from. Arrays of images are
(rows, columns). Faults in what is handed over raise knuckle.Error, a ValueError.
"""

import functools as _functools
import json as _json
import os as _os

import numpy as _numpy  # noqa: F401 - says itself where it is missing

from ._knuckle import (Camera, Error, Estimate, Estimator, Frame, Hand, HandSkeleton, Patch, Pipeline, SkeletonFit, Stream, Tracker,
                       TrueHand, __version__, conventions, data_file, open_stream)
from . import _knuckle
from ._source import Source, open_source

__all__ = ["Camera", "Error", "Estimate", "Estimator", "Frame", "Hand", "HandSkeleton", "Patch", "Pipeline", "SkeletonFit", "Source", "Stream",
           "Tracker", "TrueHand", "conventions", "data_file", "evaluate", "open_source", "open_stream", "render"]

for _class in (Camera, Estimate, Estimator, Frame, Hand, HandSkeleton, Patch, Pipeline, SkeletonFit, Source, Stream,
               Tracker, TrueHand):
    _class.__module__ = __name__  # users know no other name of it, and pickles name it so
del _class


@_functools.lru_cache(maxsize=4)
def _manifest_source(path, changed_ns):
    """Opening a manifest reads a body of 6 MB: done again only where the file has changed."""
    del changed_ns
    return Source(_knuckle.open_manifest(path), f"synthetic:{path}")


def render(manifest, index):
    """Frame `index` of a manifest (a path; negative from the end), as a Frame with depth, mask, infrared and landmarks.

    A frame depends on manifest and index alone. The last four manifests stay open. Safe to call from many threads, and
    from worker processes. Raises IndexError beyond the manifest's frames, knuckle.Error where it is wrong.
    """
    path = _os.path.abspath(_os.fspath(manifest))
    try:
        changed_ns = _os.stat(path).st_mtime_ns
    except OSError:
        changed_ns = None  # opening it says what is wrong
    return _manifest_source(path, changed_ns)[index]


def evaluate(truth, predictions, *, convention=None, camera=None, boxes=None, landmarks=None, common=False, format="uvd",
             axes="x,y,z", unit="mm"):
    """Scores of predicted poses against truth, as a dict of what `knuckle evaluate --json` writes.

    truth: a source with labels, as text ("folder:my_set"), or the path of a poses file, then with its `camera`.
    predictions: dict of a method's name and its poses: the path of a poses file, or an array (frames, J, 3) of column,
        row [px] and depth [mm] (or as `format` says), NaN where a joint is not known.
    convention: of files that do not name theirs, and of arrays: a name, or the file (.toml) of one of your own; None:
        arrays are in knuckle22.
    boxes: dict of a method's name and the path of the boxes that `knuckle segment` wrote.
    landmarks: the path of a landmark definition (`knuckle landmarks`), to whose landmarks predictions are moved before.
    format: what the three numbers of a joint are, in arrays and in files that do not say it: "uvd", or "xyz" for a point
        in camera coordinates.
    axes: where the numbers of "xyz" point, told in x (right), y (down) and z (forward); OpenGL's are "x,-y,-z".
    unit: of "xyz", or of the depth: "mm", "cm" or "m".
    common: whether to score the methods also in the landmarks that all of them share ("in_common").

    Ctrl-C ends it.
    """
    truth = _os.fspath(truth)
    return _json.loads(_knuckle.evaluate_as_json(truth, dict(predictions), convention, camera, dict(boxes or {}), landmarks,
                                                  common, format, axes, unit))
