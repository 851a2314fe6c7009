# SPDX-License-Identifier: MPL-2.0
"""Shapes between shapes: errors against an armature, triangles turned over, seams of grafts, and seconds.

The linear blend is Alexa's morph of Laplacian coordinates as well: both are linear in the shapes, so that with one
weight for all vertices they are the same. `Poisson` is Xu et al. 2005.
"""

import argparse
import itertools
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

import meanvalue

from blender_tests.support import bent_tubes, mesh_files
from native.benchmarks import reporting, shape_metrics
from native.benchmarks.generated_meshes import BAR_LENGTH

LIMBS = {
    "bend 150": None,
    "elbow 140": [(5, (1, 0, 0), 140)],
    "two joints 70": [(3, (1, 0, 0), 70), (7, (1, 0, 0), 70)],
    "three axes": [(2.5, (1, 0, 0), 100), (5, (0, 1, 0), 100), (7.5, (1, 1, 0), 80)],
    "twist 160": [(2 + k, (0, 0, 1), 160 / 6) for k in range(6)],
    "twist 160, one joint": [(5, (0, 0, 1), 160)],
}
LIMB_VERTICES = 4000
SPEED_VERTICES = (10_000, 50_000)


def pose(vertices, joints, share):
    if joints is None:
        return bent_tubes.bent(vertices, 150 * share)
    return bent_tubes.posed(vertices, [(height, axis, share * angle) for height, axis, angle in joints])


def limb_rows():
    vertices, faces = bent_tubes.tube(LIMB_VERTICES, radius=0.6)
    for name, joints in LIMBS.items():
        end = pose(vertices, joints, 1.0)
        morpher = meanvalue.Morpher([vertices, end], faces)
        for share in (0.25, 0.5):
            truth = pose(vertices, joints, share)
            solution = morpher.solve([1 - share, share])
            linear = bent_tubes.rms((1 - share) * vertices + share * end, truth)
            poisson = bent_tubes.rms(meanvalue.baselines.poisson_morph(vertices, end, faces, share), truth)
            ours = bent_tubes.rms(solution.vertices, truth)
            yield [name, share, linear, poisson / linear, ours / linear]


def shape_sets():
    """name -> (shapes, faces) of the shared data; none where that is missing."""
    data = mesh_files.DATA
    sets = {}
    if (data / "models" / "human_man.obj").exists():
        read = [mesh_files.read_triangles(data / "models" / f"human_{who}.obj") for who in ("man", "woman")]
        sets["man, woman"] = ([vertices for vertices, _ in read], read[0][1])
    for name in ("horse_poses", "face_poses"):
        if (data / "poses" / f"{name}.npz").exists():
            with np.load(data / "poses" / f"{name}.npz") as poses:
                shapes = [poses["rest"], *poses["poses"]]
                sets[name] = ([np.asarray(shape, np.float64) for shape in shapes], poses["faces"])
    if (data / "makehuman" / "base.obj").exists():
        sets["makehuman"] = makehuman_shapes(data / "makehuman")
    return sets


def makehuman_shapes(folder):
    """The body, and it with each target."""
    vertices, triangles = mesh_files.read_triangles(folder / "base.obj")
    body = 13380  # the rest is helper geometry
    triangles = triangles[(triangles < body).all(axis=1)]
    shapes = [vertices[:body]]
    for path in sorted(folder.glob("*.target")):
        lines = [line.split() for line in path.read_text().splitlines() if line and line[0].isdigit()]
        moved = vertices.copy()
        moved[[int(line[0]) for line in lines]] += np.array([line[1:4] for line in lines], np.float64)
        shapes.append(moved[:body])
    return shapes, triangles


def new_flips(shape, ends, faces):
    """How many triangles are turned over as seen from both ends, which are not so as seen from each other."""
    between = shape_metrics.flipped_mask(ends[1], ends[0], faces) | shape_metrics.flipped_mask(*ends, faces)
    from_ends = [shape_metrics.flipped_mask(shape, end, faces) for end in ends]
    return int((from_ends[0] & from_ends[1] & ~between).sum())


def flip_rows(pairs):
    """Triangles turned over half-way, and between the ends."""
    for name, (shapes, faces) in shape_sets().items():
        chosen = list(itertools.combinations(range(len(shapes)), 2))
        for a, b in chosen[:: max(1, len(chosen) // pairs)]:
            ends = [shapes[a], shapes[b]]
            morpher = meanvalue.Morpher(ends, faces)
            solution = morpher.solve([0.5, 0.5])
            halves = {
                "ours": solution.vertices,
                "linear": 0.5 * (ends[0] + ends[1]),
                "poisson": meanvalue.baselines.poisson_morph(*ends, faces, 0.5),
            }
            back = max(
                np.linalg.norm(morpher.solve(weights).vertices - end, axis=1).max() / bent_tubes.diagonal(end)
                for weights, end in zip(np.eye(2), ends, strict=True)
            )
            turned = [shape_metrics.flipped_triangles(ends[1], ends[0], faces)]
            turned += [new_flips(half, ends, faces) for half in halves.values()]
            yield [f"{name} {a}-{b}", len(shapes[0]), *turned, back]


def graft_row():
    """A bump of the second shape on the first, with an edge of some triangles: jumps of normals, and detail kept."""
    vertices, faces = bent_tubes.tube(LIMB_VERTICES)
    other = bent_tubes.bent(vertices * [1.1, 1.1, 1.0], 60)
    other *= 1.0 + 0.02 * np.sin(9 * other[:, [0]]) * np.sin(9 * other[:, [2]])
    share = np.clip((vertices[:, 2] - 4.5) / 1.0, 0, 1)
    shape = meanvalue.Morpher([vertices, other], faces).solve([1 - share, share]).vertices
    edges = shape_metrics.inner_edges(faces)

    def angles(of):
        return np.abs(shape_metrics.dihedrals(of, faces, edges))

    middle = share[edges[:, :2]].mean(axis=1)
    seam, pasted = (middle > 0) & (middle < 1), middle == 1
    sources = np.maximum(angles(vertices)[seam].max(), angles(other)[seam].max())
    kept = np.degrees(np.sqrt(np.mean((angles(shape)[pasted] - angles(other)[pasted]) ** 2)))
    return [len(vertices), np.degrees(angles(shape)[seam].max()), np.degrees(sources), kept]


def speed_rows():
    for count in SPEED_VERTICES:
        vertices, faces = bent_tubes.tube(count, radius=0.6)
        shapes = [vertices, *(pose(vertices, LIMBS[name], 1.0) for name in ("elbow 140", "three axes", "twist 160"))]
        ends = np.flatnonzero((vertices[:, 2] < 0.4) | (vertices[:, 2] > BAR_LENGTH - 0.4)).astype(np.int32)
        one, _ = reporting.median_seconds(lambda: meanvalue.Deformer(vertices, faces, ends), 3)  # noqa: B023
        four, morpher = reporting.median_seconds(lambda: meanvalue.Morpher(shapes, faces), 3)  # noqa: B023
        weights = [np.array([0.4 - t, 0.3, 0.1 + t, 0.2]) for t in np.linspace(0, 0.3, 9)]
        frames = iter(weights)
        seconds, _ = reporting.median_seconds(lambda: morpher.solve(next(frames)), len(weights))  # noqa: B023
        yield [len(vertices), four, four / one, 1e3 * seconds, morpher.report.bytes / 1e6]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--pairs", type=int, default=5, help="pairs of shapes of each set (default: 5)")
    arguments = parser.parse_args()
    tables = {
        "Against an armature: rms error over the diagonal, of the others as shares of the linear blend's": (
            ["limb", "share", "linear", "Poisson", "ours"], limb_rows,
        ),
        "Real shapes: triangles turned over between the ends, and half-way alone; how far ends are missed": (
            ["shapes", "vertices", "ends differ", "ours", "linear", "Poisson", "ends"],
            lambda: flip_rows(arguments.pairs),
        ),
        "A graft: largest angle between triangles across the seam, that of the sources, rms change inside, degrees": (
            ["vertices", "seam", "sources", "inside"], lambda: [graft_row()],
        ),
        "Four shapes: bind, over that of one Deformer, a frame": (
            ["vertices", "bind s", "ratio", "frame ms", "MB"], speed_rows,
        ),
    }  # fmt: skip
    for title, (columns, rows) in tables.items():
        reporting.report(title, columns, list(rows()), arguments.json)


if __name__ == "__main__":
    main()
