# SPDX-License-Identifier: Apache-2.0
"""A Knuckle body in Python: its arrays, how to make them, and checks (docs/import.md).

Lengths are mm; axes are x to the body's left, y up, z to the front.
"""
import dataclasses

import numpy as np

BONES_A_VERTEX = 4
WEIGHT_SUM_TOLERANCE = 1e-3
GROUP_TOLERANCE_MM = 5e-3  # single precision 2 m from the origin, and some

FINGERS = ("thumb", "index", "middle", "ring", "little")
LANDMARKS = (
    "wrist",
    "palm",
    *(f"thumb_{joint}" for joint in ("cmc", "mcp", "ip", "tip")),
    *(f"{finger}_{joint}" for finger in FINGERS[1:] for joint in ("mcp", "pip", "dip", "tip")),
)
MCPS = tuple(f"{finger}_mcp" for finger in FINGERS[1:])


def generator_bone_names():
    """Landmark -> name of the bone whose head it is, as the generator's poses call it (MakeHuman's names)."""
    names = {"wrist": "wrist.R"}
    for number, finger in enumerate(FINGERS, start=1):
        for joint, landmark in enumerate(
            [name for name in LANDMARKS if name.startswith(finger)][:3], start=1
        ):
            names[landmark] = f"finger{number}-{joint}.R"
    return names


class BodyError(ValueError):
    """A fault of the model or of what the user asked for, in one line."""


def fail(message):
    raise BodyError(message)


@dataclasses.dataclass
class Group:
    """A point as a weighted mean of vertices; the weights sum to 1 and may be negative."""

    vertices: np.ndarray  # N int32
    weights: np.ndarray  # N float32

    def position(self, points):
        return self.weights.astype(np.float64) @ np.asarray(points, np.float64)[self.vertices]


@dataclasses.dataclass
class ShapeDirection:
    name: str
    vertices: np.ndarray  # N int32
    offsets_mm: np.ndarray  # N x 3 float32


@dataclasses.dataclass
class Body:
    v_template: np.ndarray  # V x 3 float32 [mm]
    faces: np.ndarray  # F x 3 int32, counter-clockwise from outside
    is_hand: np.ndarray  # F uint8
    weight_bones: np.ndarray  # V x 4 int32
    weights: np.ndarray  # V x 4 float32, sum to 1
    names: list  # B texts, parents before children
    parents: np.ndarray  # B int32, -1 for a root
    joint_regressor: list  # B Groups: the bones' heads
    landmark_regressor: list  # 22 Groups, in the order of LANDMARKS
    landmark_bones: np.ndarray  # 22 int32
    shapedirs: list = dataclasses.field(default_factory=list)  # K ShapeDirections


def sparse_direction(name, offsets_mm):
    """The shape direction of V x 3 offsets, without the vertices that it leaves where they are."""
    offsets = np.asarray(offsets_mm, np.float32)
    if not np.isfinite(offsets).all():
        fail(f"shape direction '{name}' has an offset that is not finite")
    moved = np.flatnonzero(np.any(offsets != 0, axis=1))
    return ShapeDirection(name, moved.astype(np.int32), offsets[moved])


def strongest_weights(dense):
    """V x 4 bones and weights of V x B: the strongest four, scaled to sum to 1; the largest share dropped."""
    dense = np.asarray(dense, np.float64)
    finite = np.isfinite(dense).all(axis=1)
    if not finite.all():
        fail(f"a weight of vertex {np.flatnonzero(~finite)[0]} is not a finite number")
    if (dense < 0).any():
        fail(f"a weight of vertex {np.flatnonzero((dense < 0).any(axis=1))[0]} is negative")
    sums = dense.sum(axis=1)
    if (sums <= 1e-4).any():  # what Blender, too, takes for no weight
        lost = np.flatnonzero(sums <= 1e-4)
        fail(f"vertex {lost[0]} has no weights: {len(lost)} of {len(sums)} vertices move with no bone")
    if dense.shape[1] < BONES_A_VERTEX:
        dense = np.pad(dense, ((0, 0), (0, BONES_A_VERTEX - dense.shape[1])))
    bones = np.argsort(-dense, axis=1, kind="stable")[:, :BONES_A_VERTEX]
    kept = np.take_along_axis(dense, bones, axis=1)
    kept_sums = kept.sum(axis=1, keepdims=True)
    bones = np.where(kept > 0, bones, 0)
    return (
        bones.astype(np.int32),
        (kept / kept_sums).astype(np.float32),
        float(np.max(1 - kept_sums[:, 0] / sums)),
    )


def affine_weights(point, vertices):
    """The weights nearest to equal ones that sum to 1 and whose mean of `vertices` is `point`, or None."""
    count = len(vertices)
    offsets = (vertices - point) / max(np.abs(vertices - point).max(), 1e-9)
    system = np.vstack([offsets.T, np.ones(count)])
    equal = np.full(count, 1.0 / count)
    target = np.array([0.0, 0.0, 0.0, 1.0])
    weights = equal + np.linalg.pinv(system) @ (target - system @ equal)
    return weights if np.abs(system @ weights - target).max() < 1e-6 else None


def point_as_group(point, vertices, candidates):
    """The Group of some of the `candidates` (vertex numbers) whose mean is `point`.

    It takes the nearest vertices, as few as give no negative weight (then the point lies among them, and
    follows them when the shape changes); where no number does, the one whose negative weights are smallest.
    """
    points = np.asarray(vertices, np.float64)
    candidates = np.asarray(candidates)
    if len(candidates) == 0:
        fail(f"no vertices around {np.round(point, 3)} mm")
    distances = np.linalg.norm(points[candidates] - point, axis=1)
    order = candidates[np.argsort(distances, kind="stable")]
    best, count = None, 8
    while True:
        chosen = order[:count]
        weights = affine_weights(point, points[chosen])
        if weights is not None and (best is None or weights.min() > best[1].min()):
            best = (chosen, weights)
        if count >= len(order) or (best is not None and best[1].min() >= 0):
            break
        count *= 2
    if best is None:
        fail(
            f"no mean of {len(candidates)} vertices lies at {np.round(point, 3)} mm: "
            "do they lie in one plane?"
        )
    group = Group(best[0].astype(np.int32), best[1].astype(np.float32))
    error = np.linalg.norm(group.position(points) - point)
    if not error <= GROUP_TOLERANCE_MM:
        fail(f"the mean of vertices nearest to {np.round(point, 3)} mm is off by {error:.3g} mm")
    return group


def mean_group(groups, shares=None):
    """The mean of the groups' points, or the mean weighted by `shares`, which sum to 1."""
    shares = np.full(len(groups), 1.0 / len(groups)) if shares is None else shares
    total = {}
    for group, share in zip(groups, shares):
        for vertex, weight in zip(group.vertices.tolist(), group.weights.tolist()):
            total[vertex] = total.get(vertex, 0.0) + share * weight
    return Group(np.array(list(total), np.int32), np.array(list(total.values()), np.float32))


def palm_group(landmarks):
    """The palm's centre as in Knuckle's own body: half-way between wrist and mean of the four MCPs."""
    return mean_group([landmarks["wrist"], *(landmarks[name] for name in MCPS)], [0.5] + [0.125] * 4)


def hand_faces(faces, weight_bones, weights, hand_bones):
    """F labels: 1 where the bones of the hand move a face's corners by more than a half on average."""
    share = np.where(np.isin(weight_bones, list(hand_bones)), weights, 0).sum(axis=1)
    return (share[faces].mean(axis=1) > 0.5).astype(np.uint8)


def descendants(parents, root):
    """The bone `root` and all below it."""
    found = {root}
    for bone, parent in enumerate(parents):
        if parent in found:
            found.add(bone)
    return found


def mirrored(body):
    """The body with left and right exchanged: a model of a left hand becomes one of a right hand."""
    flip = np.array([-1, 1, 1], np.float32)
    shapedirs = [
        dataclasses.replace(direction, offsets_mm=direction.offsets_mm * flip) for direction in body.shapedirs
    ]
    return dataclasses.replace(
        body, v_template=body.v_template * flip, faces=body.faces[:, ::-1].copy(), shapedirs=shapedirs
    )


def check_group(owner, group, vertex_count):
    if len(group.vertices) == 0 or len(group.vertices) != len(group.weights):
        fail(f"{owner} has {len(group.vertices)} vertices and {len(group.weights)} weights")
    if group.vertices.min() < 0 or group.vertices.max() >= vertex_count:
        fail(f"{owner} names a vertex out of the {vertex_count} of the mesh")
    total = float(np.sum(group.weights, dtype=np.float64))
    if not abs(total - 1) <= WEIGHT_SUM_TOLERANCE:
        fail(f"weights of {owner} sum to {total:.4g}, expected 1")


def check(body):
    """Fails where sizes disagree, a value is not finite, weights do not sum to 1 or parents come late."""
    vertex_count, bone_count = len(body.v_template), len(body.names)
    if vertex_count == 0 or body.v_template.shape != (vertex_count, 3):
        fail(f"v_template is {body.v_template.shape}, expected vertices x 3")
    if not np.isfinite(body.v_template).all():
        fail(
            f"v_template of vertex {np.flatnonzero(~np.isfinite(body.v_template).all(axis=1))[0]} "
            "is not finite"
        )
    if body.faces.ndim != 2 or body.faces.shape[1] != 3 or len(body.faces) == 0:
        fail(f"faces are {body.faces.shape}, expected triangles")
    if body.faces.min() < 0 or body.faces.max() >= vertex_count:
        fail(f"faces name vertex {body.faces.max()}, the mesh has {vertex_count}")
    if len(set(body.names)) != bone_count or bone_count == 0:
        fail(f"expected bones with different names, found {bone_count}: {', '.join(sorted(body.names))}")
    for bone, parent in enumerate(body.parents):
        if not -1 <= parent < bone:
            fail(f"the parent of bone '{body.names[bone]}' is {parent}, expected -1 or a bone before it")
    sums = body.weights.sum(axis=1, dtype=np.float64)
    wrong = np.flatnonzero(~(np.abs(sums - 1) <= WEIGHT_SUM_TOLERANCE))
    if len(wrong):
        fail(f"weights of vertex {wrong[0]} sum to {sums[wrong[0]]:.4g}, expected 1")
    if len({direction.name for direction in body.shapedirs}) != len(body.shapedirs):
        fail("two shape directions have the same name")
    for name, group in zip(body.names, body.joint_regressor, strict=True):
        check_group(f"joint_regressor of {name}", group, vertex_count)
    for name, group in zip(LANDMARKS, body.landmark_regressor, strict=True):
        check_group(f"landmark_regressor of {name}", group, vertex_count)


def dense_weights(body):
    dense = np.zeros((len(body.v_template), len(body.names)), np.float32)
    np.add.at(dense, (np.arange(len(dense))[:, None], body.weight_bones), body.weights)
    return dense
