# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist has chosen for a bake, checked, and the handles sampled."""

import math
import pathlib

import bpy

from ...errors import SceneError
from ...ids import CACHE_FOLDER
from ...mixing.bridge import mix_layers
from ...mixing.bridge.mixing import Mixing
from ...posing.bridge.posing import Posing
from ...scene.core import whole_files
from ...scene.core.checked_json import read_json
from ..core import bake_times
from ..properties import TO_CACHE, TO_KEYS
from . import baking, playing, sampling
from .mix_plan import MixPlan
from .plan import BakePlan


class Preparation:
    """In place of a Posing for widgets/background.py: one object with its options (attributes as bake_settings).

    plan, work_to_do: None and False until sample() went through.
    @throws SceneError if the options do not fit the object; nothing was changed then.
    """

    def __init__(self, obj, scene, options, reading=None):
        self.options = options
        self.scene_name = scene.name
        self.times = times_of(scene, options)
        self.shown_path, self.path = _paths(obj, options)
        self._require_size(obj)
        _require_place(obj, options, self.path)
        problem = playing.keys_problem(obj, options.use_absolute) if self.to_keys else None
        if problem is not None:
            raise SceneError(problem)
        self.part = self._part_rows()
        self.posing = self._posing(obj, reading)
        self.plan = self.baking = self.outcome = None
        self.notes = ()  # on what was sampled, sentences
        self.is_done = False

    @property
    def to_keys(self):
        return self.options.target == TO_KEYS

    def sample(self, find):
        """Generator of the share that is done. find() as of bridge.sampling. @throws SceneError."""
        spacing = bake_times.spacing(self.options.step, self.options.samples)
        self.plan = yield from self._plan(find, spacing)
        if self.part is not None:
            baking.require_cache(self.path, self.plan)
        self.baking = baking.Baking(self.plan, self.posing, self.path, self.part)
        self.is_done = self._is_done(find())

    def read_triangles(self, obj):
        if not self.is_done:
            self.posing.read_triangles(obj)

    def work(self, execution):
        """Steps (see workers.job) that solve. @throws MeanValueError."""
        if not self.is_done:
            yield from self.baking.work(execution)

    def write(self, obj):
        """Generator of the share done: puts the cache together, or chooses the shape keys. @throws CacheError."""
        if self.is_done:
            return
        about = {"object": obj.name, "blend": _blend_name(), "scene": self.scene_name, "target": self.options.target}
        if self.to_keys:
            self.outcome = yield from self._counted(self.baking.choose_keys(*self._tolerance()))
            if bpy.data.filepath:
                self.baking.write_report(self.outcome[2], {**about, "key": self.plan.key})
        else:
            self.outcome = yield from self._counted(self.baking.write_cache(about))

    def require_unchanged(self, obj, reading):
        """@throws SceneError if the mesh is another by now."""
        self.posing.require_unchanged(obj, reading)

    def keys_identity(self):
        """Of what is made in shape keys, to know it again."""
        options = self.options
        return f"{self.plan.key} {self._tolerance()} {options.use_absolute} {options.prefix}"

    def _posing(self, obj, reading):
        """What binds. @throws SceneError, StaleBindingError."""
        return Posing.to_bake(obj, reading)

    def _plan(self, find, spacing):
        """Generator of the share that is done, which returns the plan."""
        bind_input = self.posing.bind_input
        samples = yield from sampling.sample(self.scene_name, find, bind_input, self.times)
        self.notes = samples.notes
        return BakePlan(bind_input, self.times, spacing, samples.targets, samples.weights)

    def _is_done(self, obj):
        """Whether the files, or the shape keys, are there already."""
        if self.part is not None:
            return False
        if not self.to_keys:
            return baking.is_current(self.path, self.plan)
        return obj.meanvalue.baked.key == self.keys_identity() and playing.has_all_keys(obj)

    def _tolerance(self):
        """(tolerance as a distance or None, key_step)."""
        options = self.options
        if options.keys == "EVERY":
            return None, options.key_step
        if options.tolerance_kind == "DISTANCE":
            return options.tolerance, 1
        return options.tolerance_share / 100.0 * self.posing.bind_input.diagonal, 1

    def _counted(self, steps):
        """Shares in place of row numbers."""
        count = max(1, self.baking.total)
        while True:
            try:
                row = next(steps)
            except StopIteration as end:
                return end.value
            yield min(1.0, row / count)

    def _require_size(self, obj):
        if self.options.confirm_size:
            return
        problem = size_problem(obj, self.times, self.options)
        if problem:
            raise SceneError(f"{problem}. If that is what you want, bake with confirm_size=True")

    def _part_rows(self):
        options = self.options
        if not options.use_part:
            return None
        if self.to_keys:
            raise SceneError("Shape keys are baked as a whole. Turn Part Only off, or bake to a point cache")
        if options.part_end < options.part_start:
            raise SceneError(f"The part ends before it begins (frames {options.part_start} to {options.part_end})")
        return bake_times.rows_of(self.times, options.part_start, options.part_end)


class MixPreparation(Preparation):
    """As Preparation, for the animated sliders of a rotation-aware mix."""

    def _posing(self, obj, _reading):
        return Mixing(mix_layers.gather(obj))

    def _plan(self, find, spacing):
        mix_input = self.posing.bind_input
        names = [layer.name for layer in mix_input.layers]
        values = yield from sampling.sample_sliders(self.scene_name, find, names, self.times)
        return MixPlan(mix_input, self.times, spacing, values)


def times_of(scene, options):
    """f float64: the frames to sample. @throws SceneError."""
    first, last = options.frame_start, options.frame_end
    if options.frame_range == "SCENE":
        first, last = scene.frame_start, scene.frame_end
    elif options.frame_range == "PREVIEW":
        if not scene.use_preview_range:
            raise SceneError("The scene has no preview range. Set one in the timeline (P), or choose another range")
        first, last = scene.frame_preview_start, scene.frame_preview_end
    return bake_times.sample_times(first, last, options.step, options.samples)


def size_problem(obj, times, options):
    """A sentence if what is chosen would hurt, else None. Adaptive keys are known only when they are chosen."""
    keys = None
    if options.target == TO_KEYS:
        if options.keys == "ADAPTIVE":
            return None
        keys = math.ceil((len(times) - 1) / options.key_step) + 1
    return bake_times.size_problem(len(times), len(obj.data.vertices), keys)


def default_path(obj):
    """As the modifier shows it."""
    return f"//{CACHE_FOLDER}/{bpy.path.clean_name(obj.name)}.pc2"


def _paths(obj, options):
    """(as the modifier shows it, in full). For shape keys: where chunks and report are. @throws SceneError."""
    shown = options.path.strip() or default_path(obj)
    if options.target == TO_KEYS:
        folder = f"//{CACHE_FOLDER}" if bpy.data.filepath else bpy.app.tempdir
        full = pathlib.Path(bpy.path.abspath(folder), f"{bpy.path.clean_name(obj.name)}.keys")
        return "", full
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
        shown += ".pc2"
        full = full.with_name(f"{full.name}.pc2")
    return shown, full


def _require_place(obj, options, path):
    """@throws SceneError if something is in the way that must not be replaced."""
    whole_files.require_place(path)
    if options.overwrite == "NEVER" and obj.meanvalue.baked.target:
        raise SceneError(f"'{obj.name}' is baked already. Choose another setting of Overwrite, or press Remove Bake")
    if options.target != TO_CACHE or options.overwrite == "ANY" or not path.exists():
        return
    if options.overwrite == "NEVER":
        raise SceneError(f"There is a file '{path}' already. Choose another path, or another setting of Overwrite")
    marker = read_json(baking.report_path(path)) or {}
    if (marker.get("object"), marker.get("blend")) != (obj.name, _blend_name()):
        whose = "something else than a bake"
        if marker.get("object") == obj.name:
            whose = (
                f"the bake of '{obj.name}' in '{marker.get('blend') or 'an unsaved file'}', as which this file may "
                "have been saved before"
            )
        elif "object" in marker:
            whose = f"the bake of '{marker['object']}' in '{marker.get('blend') or 'an unsaved file'}'"
        size = whole_files.in_bytes(path.stat().st_size)
        raise SceneError(
            f"'{path}' ({size}) is {whose}. Choose another path, or set Overwrite to Any if it may be replaced"
        )


def _blend_name():
    return pathlib.Path(bpy.data.filepath).name if bpy.data.filepath else ""
