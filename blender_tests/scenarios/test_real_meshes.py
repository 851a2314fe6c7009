# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as artists have them, by the operators: a scanned feline lifts a wing tip, a beast of quads an arm.

Numbers cannot tell whether a pose looks natural: change one only after looking at it. Skipped where the shared data is
missing.
"""

import time
from contextlib import contextmanager

import bpy
import numpy as np
import pytest
from support import meshes, steps
from support.snapshot import assert_same, snapshot

from blender_tests.demo import arguments, motion, pose, scene_mesh, user_file
from blender_tests.demo.off_file import read_off
from blender_tests.support.mesh_files import DATA, read_obj

pytestmark = pytest.mark.slow

CHANGING = ("keys", "active key", "settings", "relative", "datablocks")
FELINE, BEAST = DATA / "models" / "feline.off", DATA / "models" / "beast_quads.obj"

# Which way is up; (middle, radius) of the tip and of the region, and whether that is only what hangs together there;
# axis, degrees and centre of the tip's turn.
# The region is the wing without the horn beside it. The tip's patch turns about the wing's middle, as the end of
# a strip that bends evenly does. A single vertex as anchor leaves the wing free to twist and to narrow.
LIFT_WING_TIP = (
    *("-Z", ((0.0232, 0.0618, -2.061), 0.06), ((-0.08, 0.55, -1.8), 0.58), True),
    *((1.0, 0.0, 0.0), 45.0, (0.0, 0.12, -1.735)),
)
# The centre is in the upper arm, halfway between the region's border on the chest and the wrist, because the
# bend is spread over all that is free. About the shoulder, the same turn thins the upper arm.
SWING_ARM = (
    *(None, ((122.0, 160.0, 65.0), 30.0), ((90.0, 185.0, 24.0), 88.0), False),
    *((0.0, 0.0, 1.0), 25.0, (72.0, 191.0, 15.0)),
)


def where_present(path, *values):
    """Parameters of a test, skipped with the reason where the mesh file is missing."""
    missing = pytest.mark.skipif(not path.is_file(), reason=f"there is no {path.name} in {path.parent}")
    return pytest.param(path, *values, id=path.name, marks=missing)


@contextmanager
def timed(seconds, stage):
    start = time.perf_counter()
    yield
    seconds[stage] = time.perf_counter() - start


def loaded(path, up=None):
    """The mesh object of a file, as the demo has it."""
    obj = user_file.load(arguments.parse([str(path)]))
    user_file.prepare(obj, up)
    return obj


class Posed:
    """A mesh file posed by the operators, and how it was before."""

    def __init__(self, path, up, tip, region, is_part, axis, degrees, centre):
        self.seconds = {}
        with timed(self.seconds, "load"):
            self.obj = obj = loaded(path, up)
        meshes.activate(obj)
        self.rest = pose.positions(obj)
        self.anchors, (self.roi, nearest) = self.ball(*tip)[0], self.ball(*region)
        if is_part:
            self.roi = scene_mesh.connected_part(self.roi, nearest, scene_mesh.edges(obj))
        self.targets = motion.turned(self.rest, axis, np.radians(degrees), centre)
        for name, members in (("tip", self.anchors), ("region", self.roi)):
            scene_mesh.add_vertex_group(obj, name, np.flatnonzero(members))
        bpy.context.view_layer.update()  # else the object's matrix is rounded after the first snapshot
        self.before = snapshot(obj, without=CHANGING)
        self.pose()

    def ball(self, middle, radius):
        """((n,) bool, the vertex nearest to its middle)."""
        away = np.linalg.norm(self.rest - middle, axis=1)
        return away <= radius, away.argmin()

    def pose(self):
        assert bpy.ops.meanvalue.add_handle(pin=True, group="tip") == {'FINISHED'}
        self.obj.meanvalue.roi_group = "region"
        with timed(self.seconds, "bind"):
            assert bpy.ops.meanvalue.bind() == {'FINISHED'}
        steps.add_pose_key(self.obj)
        for index in np.flatnonzero(self.anchors):
            self.obj.active_shape_key.data[index].co = self.targets[index]
        with timed(self.seconds, "solve"):
            steps.solve()
        self.result = steps.key_positions(self.obj, "Mean-Value")

    def edge_length_ratios(self):
        """Length in the result over length at rest, of the edges with a free end."""
        edges = scene_mesh.edges(self.obj)
        edges = edges[(self.roi & ~self.anchors)[edges].any(axis=1)]
        rest, result = (
            np.linalg.norm(positions[edges[:, 0]] - positions[edges[:, 1]], axis=1)
            for positions in (self.rest, self.result.astype(np.float64))
        )
        return result / rest

    def report(self):
        bound = steps.summary(self.obj)
        times = ", ".join(f"{stage} {value:.2f} s" for stage, value in self.seconds.items())
        shares = ", ".join(f"p{p} {np.percentile(self.edge_length_ratios(), p):.3f}" for p in (1, 50, 99))
        return (
            f"\n{self.obj.name}: {len(self.rest):,} vertices, {bound.free_count:,} free, "
            f"{bound.anchor_count:,} anchors; {times}; edge lengths over rest: {shares}"
        )


@pytest.mark.parametrize(
    ("path", "how", "read"),
    [where_present(FELINE, LIFT_WING_TIP, read_off), where_present(BEAST, SWING_ARM, read_obj)],
)
def test_a_limb_follows_its_anchors_and_nothing_else_changes(path, how, read, capfd):
    posed = Posed(path, *how)
    assert "stopped before it had converged" not in capfd.readouterr().out
    with capfd.disabled():
        print(posed.report())
    check_outcome(posed)
    check_nothing_else_changed(posed)
    check_against_the_file(posed, *read(path))
    check_lengths(posed)


def check_outcome(posed):
    assert posed.obj.data.shape_keys.key_blocks.keys() == ["Basis", "Pose", "Mean-Value"]
    assert steps.summary(posed.obj).free_count == (posed.roi & ~posed.anchors).sum()
    assert np.isfinite(posed.result).all()
    assert np.array_equal(posed.result[posed.anchors], posed.targets[posed.anchors].astype(np.float32))
    free = posed.roi & ~posed.anchors
    assert (posed.result[free] != posed.rest[free]).any(axis=1).mean() > 0.99


def check_nothing_else_changed(posed):
    outside = ~posed.roi & ~posed.anchors
    rest = posed.rest.astype(np.float32)
    assert posed.result[outside].tobytes() == rest[outside].tobytes()
    assert steps.key_positions(posed.obj, "Basis").tobytes() == rest.tobytes()
    assert_same(posed.before, snapshot(posed.obj, without=CHANGING))


def check_against_the_file(posed, vertices, polygons):
    """Vertex order, polygon sizes and corners are the file's own."""
    outside = ~posed.roi & ~posed.anchors
    assert np.allclose(posed.result[outside], vertices[outside], rtol=1e-6, atol=1e-6)
    assert [list(polygon.vertices) for polygon in posed.obj.data.polygons] == polygons


def check_lengths(posed):
    low, middle, high = np.percentile(posed.edge_length_ratios(), (1, 50, 99))
    assert 0.97 < middle < 1.03
    assert low > 0.85, "something is squeezed"
    assert high < 1.18, "something is stretched"


@pytest.mark.parametrize("path", [where_present(BEAST)])
def test_quads_uv_map_and_material_are_there_to_be_kept(path):
    """Without them the comparison of before and after would say nothing."""
    mesh = loaded(path).data
    sizes = np.array([polygon.loop_total for polygon in mesh.polygons])
    assert (sizes == 4).mean() > 0.99
    assert (sizes != 4).any()
    assert len(mesh.uv_layers) == 1
    assert len({tuple(corner.uv) for corner in mesh.uv_layers[0].data}) > 30_000
    assert len(mesh.materials) == 1
