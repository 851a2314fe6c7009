# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist has chosen for a bake, checked, and the animation sampled."""

import math
import pathlib

import bpy

from ... import wording
from ...errors import SceneError
from ...ids import CACHE_FOLDER
from ...scene import bakeable
from ...scene.baked import TO_CACHE, TO_KEYS
from ...scene.core import whole_files
from ...scene.core.checked_json import read_json
from ..core import bake_times, point_cache
from . import baking, handle_source, playing, row_source, sampling
from .plan import BakePlan

#: What is larger asks first.
LARGE_BYTES = 1_000_000_000
MANY_KEYS = 500

#: Memory of a shape key, for each vertex: positions, and the copy that Blender evaluates.
KEY_BYTES_PER_VERTEX = 24


class Preparation:
    """In place of a Posing for widgets/background.py: one object with its options (attributes as properties.py).

    plan, baking: None until sample() went through.
    @throws SceneError if the options do not fit the object; nothing was changed then.
    """

    def __init__(self, obj, scene, options, reading=None):
        self.options = options
        self.to_keys = options.target == TO_KEYS
        self.scene_name = scene.name
        self.times = sampling.times_of(scene, obj, options)
        self.shown_path, self.path = _paths(obj, options)
        problem = size_problem(obj, self.times, options)
        if problem and not options.confirm_size:
            raise SceneError(f"{problem}. If that is what you want, bake with confirm_size=True")
        _require_place(obj, options, self.path)
        problem = playing.keys_problem(obj, options.use_absolute) if self.to_keys else None
        if problem is not None:
            raise SceneError(problem)
        self.part = self._part_rows()
        kind = bakeable.of(obj)
        self._source = row_source.Source(kind, obj) if kind else handle_source.Source(obj, reading)
        self.posing = self._source.posing
        self.plan = self.baking = self.outcome = None
        self.notes = ()  # on what was sampled, sentences
        self.is_done = False

    def sample(self, find):
        """Generator of the share that is done. find() as of bridge.sampling. @throws SceneError."""
        yield from sampling.sample(self.scene_name, find, self._source, self.times)
        self.notes = tuple(self._source.notes(find()))
        self.plan = BakePlan(self._source.clip(), self.times, self.options.step / self.options.samples)
        if self.part is not None:
            baking.require_cache(self.path, self.plan)
        self.baking = baking.Baking(self.plan, self.posing, self.path, self.part)
        self.is_done = self._is_done(find())

    def read_triangles(self, obj):
        if not self.is_done:
            self.posing.read_triangles(obj)

    def work(self, execution):
        """Steps (see solver/job.py) that solve. @throws MeanValueError."""
        if not self.is_done:
            yield from self.baking.work(execution)

    def write(self, obj):
        """Generator of the share done: puts the cache together, or chooses the shape keys. @throws CacheError."""
        if self.is_done:
            return
        about = {"object": obj.name, "blend": _blend_name(), "scene": self.scene_name, "target": self.options.target}
        if self.to_keys:
            self.outcome = yield from self._shares(self.baking.choose_keys(self._tolerance(), self.options.key_step))
            if bpy.data.filepath:
                baking.write_report(self.path, self.outcome[2], {**about, "key": self.plan.key})
        else:
            self.outcome = yield from self._shares(self.baking.write_cache(about))

    def require_unchanged(self, obj, reading):
        """@throws SceneError if the mesh is another by now."""
        self.posing.require_unchanged(obj, reading)

    def keys_identity(self):
        """Of what is made in shape keys, to know it again."""
        options = self.options
        return f"{self.plan.key} {self._tolerance()} {options.key_step} {options.use_absolute} {options.prefix}"

    def _is_done(self, obj):
        """Whether the files, or the shape keys, are there already."""
        if self.part is not None:
            return False
        if not self.to_keys:
            return baking.is_current(self.path, self.plan.key, self.plan.header)
        return obj.meanvalue.baked.key == self.keys_identity() and playing.has_all_keys(obj)

    def _tolerance(self):
        """As a distance; None for every n-th row."""
        if self.options.keys == 'EVERY':
            return None
        return self.options.tolerance_share / 100.0 * self.posing.bind_input.diagonal

    def _shares(self, steps):
        """Of the work, in place of row numbers."""
        count = max(1, self.baking.total)
        while True:
            try:
                row = next(steps)
            except StopIteration as end:
                return end.value
            yield min(1.0, row / count)

    def _part_rows(self):
        options = self.options
        if not options.use_part:
            return None
        if self.to_keys:
            raise SceneError("Shape keys are baked as a whole. Turn Part Only off, or bake to a point cache")
        if options.part_end < options.part_start:
            raise SceneError(f"The part ends before it begins (frames {options.part_start} to {options.part_end})")
        return bake_times.rows_of(self.times, options.part_start, options.part_end)


def size_problem(obj, times, options):
    """A sentence if what is chosen would hurt, else None."""
    vertices = len(obj.data.vertices)
    if options.target == TO_CACHE:
        size = cache_bytes(obj, times)
        if size <= LARGE_BYTES:
            return None
        return (
            f"The point cache of {len(times):,} samples of {wording.vertices(vertices)} will take "
            f"{whole_files.in_bytes(size)}, and as much again while it is put together"
        )
    step = options.key_step if options.keys == 'EVERY' else 1
    keys = math.ceil((len(times) - 1) / step) + 1
    size = keys * vertices * KEY_BYTES_PER_VERTEX
    if keys <= MANY_KEYS and size <= LARGE_BYTES:
        return None
    return (
        f"Up to {wording.counted(keys, 'shape key')} of {wording.vertices(vertices)} will take "
        f"{whole_files.in_bytes(size)} of memory and slow Blender down. A point cache has no such limits"
    )


def cache_bytes(obj, times):
    """Of the whole file."""
    return point_cache.Header(len(obj.data.vertices), 0.0, 1.0, len(times)).bytes


def default_path(obj):
    """As the modifier shows it."""
    return f"//{CACHE_FOLDER}/{bpy.path.clean_name(obj.name)}.pc2"


def _paths(obj, options):
    """(as the modifier shows it, in full). For shape keys: where chunks and report are. @throws SceneError."""
    if options.target == TO_KEYS:
        folder = f"//{CACHE_FOLDER}" if bpy.data.filepath else bpy.app.tempdir
        return "", pathlib.Path(bpy.path.abspath(folder), f"{bpy.path.clean_name(obj.name)}.keys")
    shown = options.path.strip() or default_path(obj)
    if shown.startswith("//") and not bpy.data.filepath:
        raise SceneError(
            "The file is not saved yet, so there is no place beside it for the point cache. Save the file, choose a "
            "full path in File, or bake to shape keys"
        )
    full = pathlib.Path(bpy.path.abspath(shown))
    if not full.is_absolute():
        raise SceneError(f"'{shown}' is no full path. Begin it with // for the folder of the .blend")
    with whole_files.telling(full):  # of a name that is too long
        is_folder = full.is_dir()
    if is_folder or shown.endswith(("/", "\\")):
        raise SceneError(f"'{shown}' is a folder. Give the point cache the name of a file")
    if full.suffix.lower() != ".pc2":
        return f"{shown}.pc2", full.with_name(f"{full.name}.pc2")
    return shown, full


def _require_place(obj, options, path):
    """@throws SceneError if something is in the way that must not be replaced."""
    whole_files.require_place(path)
    if options.target == TO_KEYS or options.overwrite_any or not path.exists():
        return
    marker = read_json(baking.report_path(path)) or {}
    if (marker.get("object"), marker.get("blend")) != (obj.name, _blend_name()):
        whose = "something else than a bake"
        if "object" in marker:
            whose = f"the bake of '{marker['object']}' in '{marker.get('blend') or 'an unsaved file'}'"
        raise SceneError(
            f"'{path}' ({whole_files.in_bytes(path.stat().st_size)}) is {whose}. Choose another path, or turn "
            "Overwrite on if it may be replaced"
        )


def _blend_name():
    return pathlib.Path(bpy.data.filepath).name if bpy.data.filepath else ""
