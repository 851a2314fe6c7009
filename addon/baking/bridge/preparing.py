# SPDX-License-Identifier: GPL-3.0-or-later
"""Which frames an artist has chosen to bake, whether that fits the object, and where it goes."""

import pathlib
import uuid

import bpy

from ... import wording
from ...errors import SceneError
from ...ids import CACHE_FOLDER
from ...scene import baked, frames
from ...scene.baked import TO_BONES, TO_CACHE, TO_KEYS
from ...scene.core import whole_files
from ...scene.core.whole_files import file_name
from ..core import bake_times, point_cache
from . import bones, handle_source, playing

#: What is larger asks first.
LARGE_BYTES = 1_000_000_000
MANY_KEYS = 500

#: Marks that this session has given: undo takes them off their objects, and the caches stay.
_made = set()


def times_of(scene, obj, options):
    """f float64: the frames to sample. @throws SceneError."""
    first, last = options.frame_start, options.frame_end
    if options.frame_range == 'SCENE':
        first, last = scene.frame_start, scene.frame_end
    elif options.frame_range == 'ANIMATION':
        first, last = frames.moved_range(scene, (baked.source(obj) or handle_source).animated(obj))
    return bake_times.sample_times(first, last, options.samples)


def target_problem(obj, options):
    """Why `obj` cannot be baked to this, in words, or None."""
    return {TO_BONES: bones.problem, TO_KEYS: playing.keys_problem}.get(options.target, lambda obj: None)(obj)


def doubts(obj, times, options, path):
    """Sentences on what the artist is asked about before it is baked so."""
    found, to_keys = [], options.target == TO_KEYS
    size = 12 * len(obj.data.vertices) * len(times) * (2 if to_keys else 1)  # of keys Blender evaluates a copy
    if size > LARGE_BYTES or (to_keys and len(times) > MANY_KEYS):
        count = wording.counted(len(times), "shape key" if to_keys else "sample")
        slow = " of memory and slow Blender down: a point cache does not" if to_keys else ""
        found.append(f"Up to {count} will take {whole_files.in_bytes(size)}{slow}")
    marker = point_cache.read_marker(path)
    if options.target == TO_CACHE and path.exists() and not _is_own(obj, marker):
        whose = "something else than a bake"
        if "object" in marker:
            whose = f"the bake of '{marker['object']}' in '{marker.get('blend') or 'an unsaved file'}'"
        found.append(f"'{path}' ({whole_files.in_bytes(path.stat().st_size)}) is {whose}, and will be replaced")
    return found


def _is_own(obj, marker):
    """Whether a bake of `obj` wrote what the marker lies beside: another file may have the same names."""
    known = {"", obj.meanvalue.bake.mark, *_made}  # "": by version 0.1
    names = marker.get("object"), marker.get("blend")
    return names == (obj.name, blend_name()) and marker.get("mark", "") in known


def write_marker(path, obj, key):
    """@throws CacheError."""
    mark = obj.meanvalue.bake.mark = obj.meanvalue.bake.mark or uuid.uuid4().hex
    _made.add(mark)
    point_cache.write_marker(path, {"key": key, "object": obj.name, "blend": blend_name(), "mark": mark})


def default_path(obj):
    """As the modifier shows it."""
    return f"//{_folder()}/{file_name_of(obj)}.pc2"


def _folder():
    """With the name of the .blend, beside which there may be others with objects of the same names."""
    stem = pathlib.Path(blend_name()).stem
    return f"{CACHE_FOLDER}/{file_name(bpy.path.clean_name(stem))}" if stem else CACHE_FOLDER


def file_name_of(obj):
    return file_name(bpy.path.clean_name(obj.name))


def paths(obj, options):
    """(as the modifier shows it, in full). For what needs no file: where it is begun. @throws SceneError."""
    if options.target != TO_CACHE:
        folder = f"//{_folder()}" if bpy.data.filepath else bpy.app.tempdir
        return "", pathlib.Path(bpy.path.abspath(folder), f"{file_name_of(obj)}.keys")
    shown = options.path.strip() or default_path(obj)
    if shown.startswith("//"):  # Blender's own modifier takes both slashes for one, on all systems
        shown = shown.replace("\\", "/")
    if shown.startswith("//") and not bpy.data.filepath:
        raise SceneError("The file is not saved yet. Save it, choose a full path in File, or bake to shape keys")
    full = pathlib.Path(bpy.path.abspath(shown))
    if not full.is_absolute():
        raise SceneError(f"'{shown}' is no full path. Begin it with // for the folder of the .blend")
    with whole_files.telling(full):  # of a name that is too long
        if full.is_dir() or shown.endswith(("/", "\\")):
            raise SceneError(f"'{shown}' is a folder. Give the point cache the name of a file")
    if full.suffix.lower() != ".pc2":
        return f"{shown}.pc2", full.with_name(f"{full.name}.pc2")
    return shown, full


def blend_name():
    return pathlib.Path(bpy.data.filepath).name if bpy.data.filepath else ""
