# SPDX-License-Identifier: GPL-3.0-or-later
"""A generated head with a dozen shape keys, and what markers on it record: arrays, without Blender."""

import numpy as np

from . import rings

#: Half of the head's size, in metres; it looks along -Y.
SIZE = np.array([0.075, 0.095, 0.12])
RINGS, SEGMENTS = 32, 48

#: {key: (where on the head: a direction, how far it moves in millimetres, how wide in metres)}; L is at +X.
_MIDDLE = {
    "jawOpen": ((0.0, -0.8, -0.65), (0, 3, -14), 0.045),
    "mouthPucker": ((0.0, -1.0, -0.42), (0, -9, 0), 0.022),
}
_SIDES = {
    "browUp": ((0.35, -0.9, 0.45), (0, 0, 8), 0.024),
    "eyeBlink": ((0.4, -0.95, 0.2), (0, -1, -7), 0.018),
    "cheekPuff": ((0.65, -0.8, -0.2), (7, -5, 0), 0.03),
    "mouthSmile": ((0.35, -0.95, -0.4), (5, 2, 6), 0.022),
    "noseSneer": ((0.15, -1.0, 0.0), (0, -2, 6), 0.018),
}
#: Nose, sockets of the eyes and lips, of the head at rest.
_FEATURES = (
    ((0.0, -1.0, -0.08), (0, -16, -4), 0.018),
    ((0.4, -0.95, 0.2), (0, 8, 0), 0.018),
    ((-0.4, -0.95, 0.2), (0, 8, 0), 0.018),
    ((0.0, -1.0, -0.42), (0, -5, 0), 0.016),
)
KEYS = (*_MIDDLE, *(f"{name}_{side}" for name in _SIDES for side in "LR"))


def rest():
    """(n, 3) float64, and faces."""
    height = np.cos(np.pi * np.arange(1, RINGS) / RINGS)
    turn = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    ring = np.sqrt(1.0 - height**2)[:, None]
    sphere = np.stack(np.broadcast_arrays(ring * np.cos(turn), ring * np.sin(turn), height[:, None]), axis=-1)
    points = np.concatenate([sphere.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    quads = rings.quads(RINGS - 1, SEGMENTS)[:, [0, 3, 2, 1]].tolist()
    first, last = np.arange(SEGMENTS), (RINGS - 2) * SEGMENTS + np.arange(SEGMENTS)
    caps = [*rings.fan(len(points) - 2, first).tolist(), *rings.fan(len(points) - 1, last)[:, ::-1].tolist()]
    points *= SIZE
    for at, moved, width in _FEATURES:
        points += near(points, at, width)[:, None] * np.array(moved) / 1000.0
    return points, quads + caps


def near(points, at, width):
    """(n,) 0 to 1: how near points are to where a direction leaves the head."""
    center = np.asarray(at) / np.linalg.norm(np.asarray(at)) * SIZE
    return np.exp(-((np.linalg.norm(points - center, axis=1) / width) ** 2))


def shapes():
    """{key: (n, 3)} in the order of KEYS."""
    points, _faces = rest()
    places = dict(_MIDDLE)
    for name, (at, moved, width) in _SIDES.items():
        for side, mirror in (("L", 1.0), ("R", -1.0)):
            flip = np.array([mirror, 1.0, 1.0])
            places[f"{name}_{side}"] = (flip * at, flip * moved, width)
    result = {}
    for name in KEYS:
        at, moved, width = places[name]
        result[name] = points + near(points, at, width)[:, None] * np.asarray(moved) / 1000.0
    return result


def values(frames=60):
    """(f, 12) float64: few keys at a time rise and fall, from rest on."""
    random = np.random.default_rng(3)
    time = np.arange(frames, dtype=np.float64)
    found = np.zeros((frames, len(KEYS)))
    for column in range(len(KEYS)):
        begin, length = random.uniform(2, 0.6 * frames), random.uniform(0.25, 0.4) * frames
        share = np.clip((time - begin) / length, 0.0, 1.0)
        found[:, column] = random.uniform(0.5, 1.0) * np.sin(np.pi * share) ** 2
    return found


def mixed(of_frame):
    """(n, 3): the head with the (12,) values of a frame."""
    points, _faces = rest()
    return points + sum(value * (shape - points) for value, shape in zip(of_frame, shapes().values(), strict=True))


def head_motion(frames):
    """(f, 4, 4): nods, turns by up to 20 degrees and moves a little, from rest on."""
    result = np.tile(np.eye(4), (frames, 1, 1))
    for frame, matrix in enumerate(result):
        phase = 2.0 * np.pi * frame / frames
        turn, nod = np.radians(20.0) * np.sin(phase), np.radians(8.0) * np.sin(2.0 * phase)
        about_z = [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
        about_x = [[1, 0, 0], [0, np.cos(nod), -np.sin(nod)], [0, np.sin(nod), np.cos(nod)]]
        matrix[:3, :3] = np.array(about_z) @ about_x
        matrix[:3, 3] = 0.02 * np.sin(phase) * np.array([1.0, 0.5, 0.2])
    return result


def marked(count=60):
    """(m,) vertex numbers: spread over the face by farthest points, and the last four over the skull."""
    points, _faces = rest()
    face = np.flatnonzero((points[:, 1] < -0.03) & (np.abs(points[:, 2]) < 0.09))
    chosen = [int(face[points[face, 1].argmin()])]
    distance = np.full(len(face), np.inf)
    while len(chosen) < count - 4:
        distance = np.minimum(distance, np.linalg.norm(points[face] - points[chosen[-1]], axis=1))
        chosen.append(int(face[distance.argmax()]))
    for way in ((1, 0.2, 0.2), (-1, 0.2, 0.2), (0, 0.1, 1), (0, 1, 0.3)):
        chosen.append(int((points @ np.array(way)).argmax()))
    return np.array(chosen)


def recorded(truth, vertices, noise=0.0, gaps=0.0, off_skin=0.0015):
    """(f, m, 3): markers `off_skin` metres outside the vertices, on the head as it moves, with noise and gaps."""
    random = np.random.default_rng(7)
    points, _faces = rest()
    outward = points[vertices] / SIZE**2
    outward *= off_skin / np.linalg.norm(outward, axis=1, keepdims=True)
    paths = np.array([mixed(of_frame)[vertices] + outward for of_frame in truth])
    turns = head_motion(len(truth))
    paths = np.einsum("fij,fmj->fmi", turns[:, :3, :3], paths) + turns[:, None, :3, 3]
    paths += noise * random.normal(size=paths.shape)
    for marker in range(paths.shape[1]):
        for begin in np.flatnonzero(random.random(len(paths)) < gaps / 5.0):
            paths[max(1, begin) : begin + 5, marker] = np.nan
    return paths
