# SPDX-License-Identifier: MPL-2.0
"""Shape keys of the ICT face on other faces: meanvalue.transfer() beside plain offsets and frames per ring.

Targets are the face with other triangles, of a third and three times its vertices, and in other shapes. Where a map of
space made the shape the truth is the key mapped, on identities it is the key's own offsets, as the face's makers have
it. Errors are means over what moves, in percent of the key's largest move; lids: how far gaps of blinks are from
the truth's, in percent of the eye's height; turned over: triangles that the truth does not turn.
"""

import collections
import heapq
import pathlib
import sys
import time

import meanvalue
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "blender_tests")]

from support import mesh_files  # noqa: E402

from native.benchmarks import reporting  # noqa: E402

COLUMNS = ["target", "vertices", "method", "moved %", "worst key %", "lids %", "turned over", "seconds"]
#: Meant with jawOpen alone: lips go through each other.
TOGETHER = "mouthClose"
EYES = ((3.25, 3.55, 9.0), (-3.25, 3.55, 9.0))  # cm
MOUTH, CHIN = (0.0, -3.4, 10.3), (0.0, -7.0, 9.5)


def normals_of(positions, faces):
    a, b, c = (positions[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def bump(points, center, radius):
    return np.exp(-np.square((points - center) / radius).sum(axis=1))[:, None]


def identity(points):
    """Another person: wider jaw, longer nose, wider eyes."""
    result = points * [1.05, 0.97, 1.02]
    result = result + bump(points, CHIN, 4.0) * (points - CHIN) * [0.25, 0.15, 0.1]
    result += bump(points, (0.0, 0.0, 12.0), 2.0) * [0.0, -0.4, 0.8]
    for eye in EYES:
        result += bump(points, eye, 2.0) * (points - eye) * [0.15, 0.0, 0.0]
    return result


def grown(points, eyes, jaw):
    """Eyes and jaw so many times as large."""
    result = points.copy()
    for eye in EYES:
        result += bump(points, eye, 2.2) * (points - eye) * (eyes - 1.0)
    return result + bump(points, CHIN, 5.0) * (points - CHIN) * (jaw - 1.0)


SHAPES = {
    "identity": (identity, False),
    "stretched by 1.5": (lambda points: points * [1.0, 1.5, 1.0], True),
    "cartoon": (lambda points: grown(points * [1.0, 0.9, 1.15], 1.35, 0.85), True),
    "large eyes and jaw": (lambda points: grown(points, 1.6, 1.5), True),
}


def finer(vertices, faces):
    """Three times the vertices: (faces, correspondence), one more in the middle of each, and edges turned to them."""
    middles = len(vertices) + np.arange(len(faces))
    beside = collections.defaultdict(list)
    for number, face in enumerate(faces):
        for k in range(3):
            beside[frozenset((face[k], face[k - 2]))].append((number, face[k], face[k - 2]))
    made = []
    for sides in beside.values():
        (f, a, b), *other = sides
        made += [(middles[f], a, middles[other[0][0]]), (middles[other[0][0]], b, middles[f])] if other else [
            (middles[f], a, b)
        ]  # fmt: skip
    where, weights = corners_of(len(vertices), faces)
    return (
        np.array(made, np.int32),
        np.concatenate([where, np.arange(len(faces), dtype=np.int32)]),
        np.concatenate([weights, np.full((len(faces), 3), 1.0 / 3.0)]),
    )


def corners_of(count, faces):
    where, weights = np.zeros(count, np.int32), np.zeros((count, 3))
    for k in range(3):
        where[faces[:, k]] = np.arange(len(faces))
    weights[faces[where] == np.arange(count)[:, None]] = 1.0
    return where, weights


def coarser(vertices, faces):
    """A third of the vertices: short edges inside collapse, as long as no triangle turns by more than 25 degrees."""
    fans = [set() for _ in vertices]
    triangles = {number: tuple(face) for number, face in enumerate(faces.tolist())}
    for number, face in triangles.items():
        for corner in face:
            fans[corner].add(number)

    def around(v):
        return {corner for number in fans[v] for corner in triangles[number]} - {v}

    def length(a, b):
        return float(np.linalg.norm(vertices[a] - vertices[b]))

    border = set(meanvalue.border_edges(len(vertices), faces.ravel(), np.arange(0, faces.size, 3)).ravel().tolist())
    queue = [(length(a, b), a, b) for a in range(len(vertices)) for b in around(a) if a not in border]
    heapq.heapify(queue)
    left = len(vertices)
    while queue and left > len(vertices) / 3:
        _, gone, to = heapq.heappop(queue)
        if not fans[gone] or not fans[to] or to not in around(gone) or len(around(gone) & around(to)) != 2:
            continue
        moved = {n: tuple(to if c == gone else c for c in triangles[n]) for n in fans[gone] - fans[to]}
        before, after = (
            np.array([normals_of(vertices, np.array([one[n]]))[0] for n in moved]) for one in (triangles, moved)
        )
        lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
        if (np.einsum("kc,kc->k", before, after) < 0.9 * lengths).any():
            continue
        for number in fans[gone] & fans[to]:
            for corner in triangles.pop(number):
                fans[corner].discard(number)
        triangles.update(moved)
        fans[to] |= fans[gone]
        fans[gone] = set()
        left -= 1
        for other in around(to):
            for a, b in ((to, other), (other, to)):
                if a not in border:
                    heapq.heappush(queue, (length(a, b), a, b))
    used = np.unique(np.array(list(triangles.values())))
    where, weights = corners_of(len(vertices), faces)
    return np.searchsorted(used, np.array(list(triangles.values()))).astype(np.int32), where[used], weights[used]


def plain(rest, there, offsets, faces):
    return rest + offsets


def frames_per_ring(rest, there, offsets, faces):
    """By the map of each ring alone."""
    frames = []
    for positions in (there, rest):
        edges = np.stack([positions[faces[:, k]] - positions[faces[:, 0]] for k in (1, 2)], axis=2)
        normals = normals_of(positions, faces)
        normals /= np.sqrt(np.linalg.norm(normals, axis=1))[:, None]
        frames.append(np.concatenate([edges, normals[..., None]], axis=2))
    maps = frames[1] @ np.linalg.inv(frames[0])
    area = np.linalg.norm(normals_of(rest, faces), axis=1)
    sums, areas = np.zeros((len(rest), 3, 3)), np.zeros(len(rest))
    for k in range(3):
        np.add.at(sums, faces[:, k], area[:, None, None] * maps)
        np.add.at(areas, faces[:, k], area)
    return rest + np.einsum("vij,svj->svi", sums / areas[:, None, None], offsets)


def lids(there, keys, names):
    """[(key, upper, lower)]: vertices of the lids that come ten times as near in a blink, or the five nearest."""
    found = []
    for name, eye in zip(("eyeBlink_L", "eyeBlink_R"), EYES, strict=True):
        key = keys[names.index(name)]
        moves = np.linalg.norm(key, axis=1)
        near = np.linalg.norm(there - eye, axis=1) < 2.2
        upper = np.flatnonzero(near & (moves > 0.6 * moves.max()))
        lower = np.flatnonzero(near & (moves < 0.3 * moves.max()))
        shape = there + key
        nearest = lower[np.linalg.norm(shape[upper][:, None] - shape[lower], axis=2).argmin(axis=1)]
        before, after = (gaps_of(each, upper, nearest) for each in (there, shape))
        meets = np.argsort(after / before)[: max(5, np.count_nonzero(after < 0.1 * before))]
        found.append((names.index(name), upper[meets], nearest[meets]))
    return found


def gaps_of(positions, upper, lower):
    return np.linalg.norm(positions[upper] - positions[lower], axis=1)


def measure(target, rest, truth, there, keys, names, faces, methods):
    rows = []
    pairs = lids(there, keys, names)
    sizes = np.linalg.norm(keys, axis=2)
    for method, run in methods.items():
        begin = time.perf_counter()
        found = run()
        seconds = time.perf_counter() - begin
        off, moves = np.linalg.norm(found - truth, axis=2), np.linalg.norm(truth - rest, axis=2)
        errors = [100.0 * off[s][sizes[s] > 1e-3 * sizes[s].max()].mean() / moves[s].max() for s in range(len(keys))]
        gaps = []
        for s, upper, lower in pairs:
            wanted, given = (gaps_of(shape[s], upper, lower) for shape in (truth, found))
            gaps.append(100.0 * np.abs(given - wanted).mean() / gaps_of(rest, upper, lower).max())
        turned, base = 0, normals_of(rest, faces)
        for shape, wanted in zip(found, truth, strict=True):
            over, also = (np.einsum("kc,kc->k", normals_of(each, faces), base) < 0.0 for each in (shape, wanted))
            turned += int((over & ~also).sum())
        lids_off = float(np.mean(gaps))
        rows.append([target, len(rest), method, float(np.mean(errors)), max(errors), lids_off, turned, seconds])
    return rows


def main():
    json_path = reporting.json_argument(__doc__)
    path = mesh_files.DATA / "poses/ict_face.npz"
    if not path.is_file():
        reporting.missing("the face with 56 keys, poses/ict_face.npz")
        return
    with np.load(path) as data:
        source, faces = data["rest"].astype(np.float64), data["faces"].astype(np.int32)
        deltas, names = data["deltas"].astype(np.float64), [str(name) for name in data["names"]]
    close = np.array([name != TOGETHER for name in names])
    same = (faces, *corners_of(len(source), faces))
    rows = []
    for label, (made, where, weights) in (
        ("", same), (", a third", coarser(source, faces)), (", three times", finer(source, faces)),
    ):  # fmt: skip
        there, keys = (np.einsum("vk,...vkc->...vc", weights, of[..., faces[where], :]) for of in (source, deltas))
        for shape, (place, is_map) in SHAPES.items():
            rest = place(there)
            truth = np.array([place(there + key) if is_map else rest + key for key in keys])
            given = source, source + deltas, faces, rest, made, (where, weights)
            methods = {
                "base and pairs": lambda given=given: meanvalue.transfer(*given, close=close),
                "base": lambda given=given: meanvalue.transfer(*given, close=np.zeros(len(names), bool)),
                "plain offsets": lambda a=(rest, there, keys, made): plain(*a),
                "frames per ring": lambda a=(rest, there, keys, made): frames_per_ring(*a),
            }
            rows += measure(shape + label, rest, truth, there, keys, names, made, methods)
    reporting.report("56 keys of the ICT face", COLUMNS, rows, json_path)


if __name__ == "__main__":
    main()
