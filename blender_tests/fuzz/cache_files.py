# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that baking and farms write and read again, and lists of frames: one class for each kind.

A kind has seeds(), whole contents; damaged(content, random_numbers); and attempt(content, folder), which reads it from
there as the add-on does: True if it was taken, False if an error of the add-on's own refused it.
"""

import importlib.util
import pathlib

import numpy as np

from addon.baking.bridge.clips import BakePlan, HandleClip
from addon.baking.core import bake_times, point_cache
from addon.errors import MeanValueError
from addon.posing.core.bind_input import BindInput

from .mutations import mutated

_SPEC = importlib.util.spec_from_file_location(
    "meanvalue_farm", pathlib.Path(__file__).resolve().parents[2] / "packaging" / "farm" / "meanvalue_farm.py"
)
FARM = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(FARM)
FARM.addon = FARM.parts_of("addon", FARM.PARTS)


def is_taken(action):
    try:
        action()
    except MeanValueError as error:
        assert str(error)
        return False
    return True


class PointCaches:
    name = "pc2"

    def __init__(self, _folder):
        rows = np.random.default_rng(1).standard_normal((3, 5, 3)).astype(np.float32)
        self.seeds = [point_cache.Header(5, 1.0, 1.0, 3).packed() + rows.tobytes()]

    damaged = staticmethod(mutated)

    def attempt(self, content, folder):
        path = folder / "a.pc2"
        path.write_bytes(content)
        return is_taken(lambda: self._read(path))

    def _read(self, path):
        header = point_cache.read_header(path)
        assert 0 in (header.samples, header.vertices) or len(point_cache.mapped(path)) == header.samples
        assert header.bytes == path.stat().st_size


def a_plan(**more):
    rest = np.array([[x, y, 0.1 * x * y] for y in range(4) for x in range(4)], np.float32)
    corners = [v + offset for v in (0, 1, 2, 4, 5, 6, 8, 9, 10) for offset in (0, 1, 5, 4)]
    bind_input = BindInput(
        rest=rest,
        face_corners=np.array(corners, np.int32),
        face_starts=np.arange(0, len(corners), 4, dtype=np.int32),
        anchors=np.array([0, 3, 12, 15], np.int32),
        roi=np.ones(16, bool),
        method="fast",
        handles=np.array([0, 0, 1, 1], np.int32),
        rigidity=15.0,
        **more,
    )
    targets = np.repeat(rest[bind_input.anchors][None].astype(np.float64), 3, axis=0)
    triangles = np.array([[v, v + 1, v + 5] for v in range(10)], np.int32)
    return BakePlan(HandleClip(bind_input, targets, None), np.arange(1.0, 4.0), 1.0), triangles


class Bundles:
    """Plans of a farm, which are refused by their checksum whatever is wrong with them."""

    name = "bundle"

    def __init__(self, folder):
        self.seeds, self._digests = [], []
        soft = {"strengths": np.array([1.0, np.inf, 2.0, np.inf])}
        border = {"border": np.array([5, 6], np.int32), "border_strengths": np.array([0.1, 0.2])}
        mirror = {"planes": np.array([[1.0, 0, 0, 0]]), "twins": np.full((1, 16), -1, np.int32)}
        for more in ({}, soft, border, mirror):
            self._digests.append(FARM.save_clip(folder / "seed.npz", *a_plan(**more)))
            self.seeds.append((folder / "seed.npz").read_bytes())

    damaged = staticmethod(mutated)

    def attempt(self, content, folder):
        path = folder / "a.npz"
        path.write_bytes(content)
        return is_taken(lambda: self._read(path, self._digests[len(content) % len(self._digests)]))

    def _read(self, path, digest):
        plan, triangles = FARM.load_clip(path, digest)
        plan.clip.bind_input.check()
        assert plan.header.samples == len(FARM.frames_of(plan)) == plan.chunks()[-1][1] and plan.key
        assert len(plan.clip.bind_input.solver_mesh.held_rest) > 0 and triangles.shape[1] == 3


class Chunks:
    """Chunks of a farm, which are refused by their checksums; markers of caches are read in test_point_cache.py."""

    damaged = staticmethod(mutated)

    name = "chunk"
    KEY = "0123abcd"

    def __init__(self, folder):
        self._rows = np.random.default_rng(2).standard_normal((4, 5, 3)).astype(np.float32)
        self._store(folder).write(1, self._rows, ["", "a", "", ""])
        self._name = next(folder.glob("*.npz")).name
        self.seeds = [(folder / self._name).read_bytes()]

    def _store(self, folder):
        return FARM.ChunkStore(folder, self.KEY, range(1, 5))

    def attempt(self, content, folder):
        (folder / self._name).write_bytes(content)
        return is_taken(lambda: self._merge(folder))

    def _merge(self, folder):
        store = self._store(folder)
        problems = store.merge(folder / "merged", point_cache.Header(5, 1.0, 1.0, 4))
        assert list(bake_times.notes([1, 2, 3, 4], problems)) == ["1 frame a (2)"]
        assert np.array_equal(point_cache.mapped(folder / "merged"), self._rows)


class FrameRanges:
    name = "frames"

    def __init__(self, _folder):
        self.seeds = [b"1-200", b"1-3,10,11", b"1..10, -5-10", b" 7 ,-3 - -1"]

    def damaged(self, content, random_numbers):
        result = bytearray(content)
        for _ in range(random_numbers.randrange(6)):
            place = random_numbers.randrange(len(result))
            result[place : place + random_numbers.randrange(2)] = [random_numbers.choice(b"0123456789-,. x\n")]
        return bytes(result)

    def attempt(self, content, _folder):
        text = content.decode("latin-1")[:40]
        return is_taken(lambda: self._read(text))

    @staticmethod
    def _read(text):
        frames = FARM.parse(text)
        assert FARM.parse(FARM.spelled(frames)) == frames


KINDS = (PointCaches, Bundles, Chunks, FrameRanges)
