# SPDX-License-Identifier: GPL-3.0-or-later
"""Which shape keys of a mesh may be driven, what they do, their values and F-curves of these."""

import numpy as np

from ... import compat, wording
from ...errors import SceneError, require_none
from ...scene import actions, shape_keys, vertex_groups
from ...solver import native_loader, session

#: Values that are beyond the range of their slider by less are not told of.
MARGIN = 1e-4


def sorted_out(obj):
    """([Slider] that may be driven, [(name, why in words)] of other keys), without the reference key and what the
    add-on itself writes; none where keys are absolute. Cheap enough for drawing."""
    keys = obj.data.shape_keys
    if keys is None or not keys.use_relative:
        return [], []
    made = shape_keys.made_names(obj)
    sliders, left_alone = [], []
    for key in keys.key_blocks:
        if key == keys.reference_key or key.name in made:
            continue
        is_driven = actions.driver_of(key)
        why = "muted" if key.mute else "locked" if compat.is_locked(key) else "moved by a driver" if is_driven else None
        if why is None:
            sliders.append(vertex_groups.slider_of(obj, key))
        else:
            left_alone.append((key.name, why))
    return sliders, left_alone


def problem(obj):
    """Why there is no key to drive, in words, or None. Cheap enough for drawing."""
    keys = obj.data.shape_keys
    if keys is not None and not keys.use_relative:
        return shape_keys.ABSOLUTE
    sliders, left_alone = sorted_out(obj)
    return None if sliders else _none_to_drive(obj, left_alone)


def _none_to_drive(obj, left_alone):
    if not left_alone:
        return f"'{obj.name}' has no shape keys to drive. Add some"
    return f"No shape key of '{obj.name}' can be driven: {left_alone_note(left_alone)}"


def left_alone_note(left_alone):
    """What of [(name, why)] is left alone, as a sentence: "'A' and 'B' (muted) are left alone"; "" if nothing is."""
    reasons = {}
    for name, why in left_alone:
        reasons.setdefault(why, []).append(name)
    parts = [f"{wording.quoted(names)} ({why})" for why, names in reasons.items()]
    return f"{wording.listed(parts)} {'is' if len(left_alone) == 1 else 'are'} left alone" if parts else ""


def gather(obj):
    """The KeyShapes of `obj`. @throws SceneError if no key has any effect."""
    require_none(problem(obj))
    sliders, left_alone = sorted_out(obj)
    found = vertex_groups.shapes_of(obj, sliders, left_alone).with_effect()
    if not found.sliders:
        raise SceneError(_none_to_drive(obj, found.left_alone))
    return found


def fit(shapes, arrays, refused, can_move):
    """The native SliderFit of KeyShapes; arrays: as of their fit_input(). @throws SolverError."""
    make, (lower, upper) = native_loader.module().SliderFit, shapes.bounds
    return session.call(make, *arrays, lower=lower, upper=upper, can_move=can_move, refused=refused)


def values(obj, names):
    """(k,) float64: where the sliders of the keys `names` are."""
    blocks = obj.data.shape_keys.key_blocks
    return np.array([blocks[name].value for name in names], np.float64)


def set_values(obj, names, found):
    """Puts the sliders of the keys `names` to the (k,) values `found`, those that are not there already."""
    blocks = obj.data.shape_keys.key_blocks
    for name, value in zip(names, found, strict=True):
        if np.float32(value) != np.float32(blocks[name].value):
            blocks[name].value = value


def curves_problem(obj):
    """Why `obj` has no shape keys with values to animate, or None. Cheap enough for drawing."""
    keys = obj.data.shape_keys
    if keys is None or len(keys.key_blocks) < 2:
        return f"'{obj.name}' has no shape keys besides the Basis. Choose the mesh that has them"
    return None if keys.use_relative else shape_keys.ABSOLUTE


def require_room(obj, names, replace):
    """@throws SceneError if values of the shape keys `names` are animated, and not to be replaced."""
    keys = obj.data.shape_keys
    animated = [name for name in names if len(actions.read_keys(keys, keys.key_blocks[name].path_from_id("value"))[0])]
    if animated and not replace:
        raise SceneError(
            f"{wording.quoted(animated)} {'is' if len(animated) == 1 else 'are'} animated already. Turn on Replace to "
            "write over that animation, or give the shape keys another action first"
        )


def write(obj, curves, replace):
    """curves: {name of a shape key: (frames, values)}, n each. Returns notes. @throws SceneError, with nothing changed,
    if values are animated and not to be replaced, or nothing can be written."""
    keys = obj.data.shape_keys
    left_out = [name for name in curves if actions.driver_of(keys.key_blocks[name])]
    writable = {name: curve for name, curve in curves.items() if name not in left_out}
    if not writable:
        raise SceneError(f"Drivers set the values of {wording.quoted(left_out)}. Delete the drivers first")
    require_room(obj, writable, replace)
    for name, (frames, values) in writable.items():
        actions.write_curve(keys, keys.key_blocks[name].path_from_id("value"), 0, frames, values)
    notes = [f"Drivers set {wording.quoted(left_out)}: left alone"] if left_out else []
    muted = [name for name in writable if keys.key_blocks[name].mute]
    if muted:
        notes.append(f"{wording.quoted(muted)} {'is' if len(muted) == 1 else 'are'} muted, so the values do not show")
    beyond = []
    for name, (_frames, values) in writable.items():
        key = keys.key_blocks[name]
        if np.min(values) < key.slider_min - MARGIN or np.max(values) > key.slider_max + MARGIN:
            beyond.append(name)
    if beyond:
        held = f"Values of {wording.quoted(beyond)} are beyond the range, which holds them"
        notes.append(f"{held}. Widen Range Min and Max")
    return notes
