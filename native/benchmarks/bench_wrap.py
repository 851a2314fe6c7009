# SPDX-License-Identifier: MPL-2.0
"""One human onto another of other faces, proportions and pose: makehuman's body onto human_man.

Distances are over the bounding-box diagonal of the man: of the body's vertices from his surface, of all and of those
with a partner there (insides of mouth and eye sockets have none), and of his vertices from the result.
"""

import pathlib
import sys
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "blender_tests")]

from support import mesh_files, wrap_calls  # noqa: E402

from addon.scene.surface import Surface  # noqa: E402
from addon.wrapping.bridge.wrapping import WrapInput  # noqa: E402
from native.benchmarks import reporting, shape_metrics  # noqa: E402

#: Vertices of both: finger tips, toes, heels, top and nose; joints of the limbs; the trunk; ears, lips, chin and lids.
PAIRS = {
    "ends": (
        (881, 411), (297, 332), (12442, 3387), (5845, 6787), (9348, 2746), (8595, 2319), (8787, 2445), (8982, 2556),
        (9171, 2673), (2680, 6191), (1927, 5782), (2119, 5905), (2314, 6016), (2503, 6133), (11551, 3215), (13133,
        3221), (13147, 3214), (12617, 3229), (13280, 3225), (4933, 6618), (6537, 6621), (6551, 6611), (6020, 6629),
        (6684, 6625),
    ),
    "joints": (
        (8226, 1861), (1547, 5325), (10042, 1643), (3374, 5113), (10548, 1969), (3883, 5669), (11242, 1043), (4624,
        4529),
    ),
    "trunk": (
        (858, 3470), (1890, 3506), (10812, 857), (4171, 4343), (10829, 3122), (4190, 6544),
    ),
    "face": (
        (12038, 583), (5439, 4071), (7185, 68), (425, 3580), (455, 3056), (492, 3069), (5225, 3051), (11488, 2787),
        (13377, 241), (4870, 6249), (6781, 6271), (6785, 2786), (6828, 2784), (1, 6246), (44, 6260),
    ),
}
SETS = {"all": tuple(PAIRS), "no face": ("ends", "joints", "trunk"), "ends and joints": ("ends", "joints")}
BODY = 13380
COLUMNS = [
    "pairs", "count", "mean %", "mean of pairs %", "largest of pairs %", "mean back %", "largest back %", "flipped",
    "seconds",
]  # fmt: skip


def two_humans():
    """(body, its triangles, man, his triangles) in their files' own spaces, or None."""
    paths = [mesh_files.DATA / name for name in ("makehuman/base.obj", "models/human_man.obj")]
    if not all(path.is_file() for path in paths):
        return None
    body, triangles = mesh_files.read_triangles(paths[0])
    return body[:BODY], triangles[(triangles < BODY).all(axis=1)], *mesh_files.read_triangles(paths[1])


def measure(name, humans):
    """(row of the table, the Wrapped)."""
    body, triangles, man, faces = humans
    picked, points = np.array([pair for group in SETS[name] for pair in PAIRS[group]]).T
    given = WrapInput(body, triangles, man, faces, picked.astype(np.int32), man[points])
    begin = time.perf_counter()
    found = wrap_calls.wrapped(given)
    seconds = time.perf_counter() - begin
    away = 100.0 * found.distance / given.diagonal
    pairs = 100.0 * np.linalg.norm(found.positions[picked] - man[points], axis=1) / given.diagonal
    back = 100.0 * Surface(found.positions, triangles).nearest(man)[3] / given.diagonal
    flipped = shape_metrics.flipped_triangles(found.positions, given.start(), triangles)
    row = [
        name, len(picked), float(away.mean()), float(pairs.mean()), float(pairs.max()), float(back.mean()),
        float(back.max()), flipped, seconds,
    ]  # fmt: skip
    return row, found


if __name__ == "__main__":
    json_path = reporting.json_argument(__doc__)
    humans = two_humans()
    if humans is None:
        reporting.missing("the two humans, makehuman/base.obj and models/human_man.obj")
    else:
        rows = [measure(name, humans)[0] for name in SETS]
        reporting.report("makehuman's body onto human_man", COLUMNS, rows, json_path)
