# SPDX-License-Identifier: GPL-3.0-or-later
"""The rest shape, the artist's pose and the result, all of them shape keys."""

import bmesh
import numpy as np

from .. import compat, ids, wording
from ..errors import SceneError
from ..rooms import ALL
from . import key_marks, mesh_arrays
from .baked import names_in
from .core.point_sets import bounding_box_diagonal, require_finite
from .key_marks import Role, result, sharing

#: Why nothing of a pose is to be seen; each begins a sentence.
BAKE_PLAYS = "A bake plays in place of the pose. Press Remove Bake to see the pose again, or bake it anew"
ABSOLUTE = "The shape keys are absolute. Turn on Relative in Object Data Properties > Shape Keys"

#: On the datablock of a mesh's keys: without it the Basis is the artist's, to be kept.
MADE = "meanvalue_made"

#: And what was written last to keys of a role, as a digest.
WRITTEN = {Role.POSE: "meanvalue_written", Role.MIX: "meanvalue_written_mix", Role.WRAP: "meanvalue_written_wrap"}


def make_basis(obj):
    """The rest shape as the first key of a mesh without any."""
    obj.shape_key_add(name=ids.BASIS_KEY, from_mix=False)
    obj.data.shape_keys[MADE] = True


def positions(key):
    """n x 3 float32 of one shape key."""
    return mesh_arrays.coordinates(*compat.key_store(key))


def held(obj, name):
    """n x 3 float32 of the shape key `name`; what the rest shape has for "", and where there is no such key."""
    keys = obj.data.shape_keys
    if keys is None:
        return mesh_arrays.vertex_positions(obj.data)
    return positions(keys.key_blocks.get(name) or keys.reference_key)


def checked(obj, name):
    """n x 3 float32 of the shape key `name`. @throws SceneError if it does not fit the mesh, or is gone."""
    keys = obj.data.shape_keys
    if keys is None or name not in keys.key_blocks:
        raise SceneError(f"'{obj.name}' has no shape key '{name}', or it was deleted meanwhile. Choose another")
    found = _fitting(obj.data, keys.key_blocks[name])
    require_finite(found, f"shape key '{name}'")
    return found


def rest_positions(mesh):
    """n x 3 float32: the reference key (Basis) if there are shape keys, else the vertices."""
    if mesh.shape_keys is None:
        return mesh_arrays.vertex_positions(mesh)
    return _fitting(mesh, mesh.shape_keys.reference_key)


def _fitting(mesh, key):
    found = positions(key)
    if len(found) != len(mesh.vertices):
        count = f"{len(found):,} points for {wording.vertices(len(mesh.vertices))}"
        raise SceneError(f"Shape key '{key.name}' has {count}. Enter and leave Edit Mode once")
    return found


def absolute_problem(obj):
    """ABSOLUTE where it is so, or None."""
    keys = obj.data.shape_keys
    return ABSOLUTE if keys is not None and not keys.use_relative else None


def result_problem(obj):
    """Why the result cannot go to the shape key that the settings name, or None. Cheap enough for drawing."""
    name, keys = key_marks.get_name(obj.meanvalue), obj.data.shape_keys
    if not name.strip():
        return "The result has no name. Fill in Result, the shape key to write"
    if absolute_problem(obj):
        return ABSOLUTE
    if keys is not None and name == keys.reference_key.name:
        return f"'{name}' is the rest shape and must not be overwritten. Give Result another name"
    return None


def ensure_result_key(obj):
    """The result key, shown fully; made if it is missing, with the Basis. Returns notes on why it does not show."""
    settings = obj.meanvalue
    key = result(obj) or unmarked(obj, Role.POSE, settings.result_name, settings.result_mark)
    if key is None:
        key = add_shape(obj, settings.result_key, rest_positions(obj.data) if obj.data.shape_keys else None)
    if key != result(obj):
        key_marks.adopt(settings, key)
    key_marks.claim(key)
    settings.result_name = key.name
    show_fully(obj.data.shape_keys, key)
    if obj.meanvalue.baked.target:
        key_marks.show(key, None)  # else the mesh would be moved twice
    why_hidden = why_result_is_hidden(obj)
    return [why_hidden] if why_hidden else []


def unmarked(obj, role, name, mark):
    """The key whose mark is gone, as where Range Min was set by hand: it has its name, and what was written last."""
    keys = obj.data.shape_keys
    key = keys.key_blocks.get(name) if keys is not None else None
    if key is None or key_marks.role(key) is not None:
        return None
    return key if is_as_written(key, role, mark) else None


def is_as_written(key, role, mark):
    """Whether the key holds what was written last to that of this role and mark: else it is another, or was edited."""
    return _digest(mark, positions(key)).startswith(key.id_data.get(WRITTEN[role], " "))


def made_names(obj):
    """Names of the keys that the add-on writes, for this object and for others with the mesh."""
    keys = obj.data.shape_keys
    names = {key.name for key in key_marks.of_role(keys, Role.MIX, Role.RIG_POSE, Role.CORRECTIVE)}
    shared = (obj, *sharing(obj))
    return names.union(*((*key_marks.pose_names(each), *names_in(each.meanvalue.baked.keys)) for each in shared))


def rig_poses(obj):
    """Names of the muted keys that have poses of the rig, as examples (Pose Like)."""
    return [key.name for key in key_marks.of_role(obj.data.shape_keys, Role.RIG_POSE) if key.mute]


def write_positions(mesh, key, shape):
    """Writes n x 3 float32 `shape` into a shape key."""
    store, attribute = compat.key_store(key)
    store.foreach_set(attribute, shape.ravel())
    role = key_marks.role(key)
    if role in WRITTEN:
        mesh.shape_keys[WRITTEN[role]] = _digest(key.slider_min, shape)
    # Blender 3.4 does not notice foreach_set. Tagging the mesh would have Blender copy that too, for a third more time.
    mesh.shape_keys.update_tag()


def write_result(obj, result):
    """Writes n x 3 float32 `result` to the result key and shows it. Returns notes as ensure_result_key()."""
    key = key_marks.result(obj)
    note = (keep_edit(obj, positions(key))[1] or keep_joined(obj, result)) if key is not None else None
    notes = ensure_result_key(obj)
    write_positions(obj.data, key_marks.result(obj), result)
    return [*notes, note] if note else notes


def _digest(mark, shape):
    """Of n x 3 float32 and the mark of their key: text, as a datablock keeps it. Older files have no n at its end."""
    return f"{mark:.9g} {np.ascontiguousarray(shape, np.float32).view(np.uint32).sum(dtype=np.uint32)} {len(shape)}"


def keep_edit(obj, held, ours=None):
    """What the artist has made of the result, in Edit or Sculpt Mode, becomes a key of its own, which none writes.

    held: n x 3 float32 of the result; ours: what was written there last, where that is known: then the edit lies on
    top of the pose, else all of it is kept at value 0. Returns (what the result holds now, a note or None).
    """
    key, written = result(obj), obj.data.shape_keys.get(WRITTEN[Role.POSE], "") if obj.data.shape_keys else ""
    is_known = key is not None and written.startswith(f"{key.slider_min:.9g} ")
    is_ours = not is_known or _digest(key.slider_min, held).startswith(written)
    fits = ours is not None and len(ours) == len(held)
    if is_ours or not (fits or obj.active_shape_key == key) or not np.isfinite(held).all():
        return held, None
    kept = add_shape(obj, f"{key.name} Edit", rest_positions(obj.data) + (held - ours) if fits else held)
    kept.value, held = float(fits), ours if fits else held
    write_positions(obj.data, key, held)
    where = "lies on top of the pose" if fits else "has value 0"
    return held, f"What was edited in '{key.name}' is kept as shape key '{kept.name}', which {where}"


def keep_joined(obj, shape):
    """What new vertices, as of an object that was joined, hold in the result becomes a key where n x 3 `shape` would
    write over it: on top of the pose where no handle moves it, else at value 0. Returns a note or None."""
    keys = obj.data.shape_keys
    if keys.get(WRITTEN[Role.POSE], "").split()[2:] in ([], [str(len(obj.data.vertices))]):
        return None
    held, rest = result_positions(obj), rest_positions(obj.data)
    if held is None or not np.isfinite(held).all():
        return None
    far = np.abs((held - shape, shape - rest)).max(axis=2) > 0.01 * bounding_box_diagonal(rest)
    key = add_shape(obj, "Joined Pose", rest + (held - shape)) if far[0].any() else None
    if key is not None:
        key.value = float(not far.all(axis=0).any())
    return key and f"The pose that came with new vertices is kept as '{key.name}', which has value {key.value:g}"


def result_positions(obj):
    """n x 3 float32 of the result key, or None if there is none that fits the mesh."""
    key = result(obj)
    if key is None or key == obj.data.shape_keys.reference_key:
        return None
    shape = positions(key)
    return shape if len(shape) == len(obj.data.vertices) else None


def pose_to_use(obj):
    """As result_positions(). @throws SceneError if there is none."""
    shape = result_positions(obj)
    if shape is None:
        raise SceneError(f"There is no shape key '{obj.meanvalue.result_key}'. Turn Live on and move a handle")
    if np.array_equal(shape, rest_positions(obj.data)):
        raise SceneError("Nothing is posed: kept poses are in their own shape keys. Move a handle first")
    return shape


def posed_positions(obj):
    """n x 3 float32: the mesh as posed, be it by the result or by other keys; None where nothing is posed."""
    for shown in ALL.shown_keys:
        shape = shown.positions(obj)
        if shape is not None:
            return shape
    return result_positions(obj)


def show_fully(keys, key):
    """So that the object takes exactly the key's positions, whatever was set on it before."""
    key.relative_key = keys.reference_key
    key.vertex_group = ""
    key.slider_min = min(key.slider_min, 0.0)
    key.slider_max = max(key.slider_max, 1.0)
    key_marks.show(key, 1.0)


def add_shape(obj, name, shape):
    """A new key of n x 3 float32, None: as the mesh; at value 0. The Basis too if missing. The active key stays so."""
    if obj.data.shape_keys is None:
        make_basis(obj)
    active_index = obj.active_shape_key_index
    key = obj.shape_key_add(name=name, from_mix=False)
    if shape is not None:
        write_positions(obj.data, key, shape)
    key.value = 0.0
    obj.active_shape_key_index = active_index
    return key


def write_only(obj, role, key, name, shape):
    """Writes n x 3 float32 to the key of a role that a mesh has one of, which is shown fully: `key`, or a new one that
    is called `name`. Returns it."""
    key = key or add_shape(obj, name, shape)
    key.slider_min = key_marks.mark(role)
    key_marks.claim(key)
    write_positions(obj.data, key, shape)
    show_fully(obj.data.shape_keys, key)
    return key


def remove(obj, names):
    """Takes away the shape keys `names` that are there, with what drives them, and a Basis that was made for them. The
    active key stays active."""
    keys = obj.data.shape_keys
    if keys is None:
        return
    active_name = obj.active_shape_key.name if obj.active_shape_key is not None else ""
    for name in names:
        key = keys.key_blocks.get(name)
        if key is not None:
            key.driver_remove("value")
            key_marks.claim(key)
            obj.shape_key_remove(key)
            _remove_from_edit_mode(obj.data, name)
    if active_name in keys.key_blocks:
        obj.active_shape_key_index = keys.key_blocks.find(active_name)
    if len(keys.key_blocks) == 1 and keys.get(MADE):
        obj.shape_key_clear()


def _remove_from_edit_mode(mesh, name):
    """Edit Mode has a copy of every key, and gives back those that are gone when it is left."""
    if not mesh.is_editmode:
        return
    layers = bmesh.from_edit_mesh(mesh).verts.layers.shape
    if name in layers:
        layers.remove(layers[name])


def why_result_is_hidden(obj):
    """Why the object does not show the result key as it is, in words, or None. Cheap enough for drawing."""
    keys, key = obj.data.shape_keys, result(obj)
    if key is None:
        return None
    if obj.meanvalue.baked.target:
        return BAKE_PLAYS
    if obj.show_only_shape_key and obj.active_shape_key not in {None, key}:
        return f"'{obj.active_shape_key.name}' is pinned: turn off Shape Key Lock to see '{key.name}'"
    if key.relative_key != keys.reference_key:
        return f"'{key.name}' is relative to '{key.relative_key.name}'. Set Relative To to '{keys.reference_key.name}'"
    if key.mute:
        return f"Shape key '{key.name}' is muted, so the pose does not show. Tick it in Object Data Properties"
    if key.value != 1.0:
        fading = [each.name for each in key_marks.replacing(obj) if each.value]
        remedy = f"Put the slider of {wording.quoted(fading)} to 0" if fading else "Set it to 1"
        return f"Shape key '{key.name}' has the value {key.value:.2f}, so the pose shows in part. {remedy}"
    return None
