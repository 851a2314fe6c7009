# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of a scene: which have motion in them, and going through them."""

import math

import bpy

from .. import compat, wording
from ..errors import SceneError
from . import actions


def moved_range(scene, datablocks):
    """(first, last) frame of the scene's range at which a keyframe moves one of the datablocks; the whole range where
    more does: drivers, physics, F-curves that go on by a modifier or by themselves."""
    whole = scene.frame_start, scene.frame_end
    ranges = []
    for each in datablocks:
        animation = each.animation_data
        driven = animation is not None and any(not curve.mute for curve in animation.drivers)
        if driven or getattr(each, "rigid_body", None) is not None:
            return whole
        if animation is None:
            continue
        curves = list(compat.curves_to_read(each) or ())
        if any(len(curve.modifiers) or curve.extrapolation == 'LINEAR' for curve in curves):
            return whole
        ranges += [curve.range() for curve in curves]
        strips = [strip for track in animation.nla_tracks if not track.mute for strip in track.strips]
        ranges += [(strip.frame_start, strip.frame_end) for strip in strips]
    if not ranges:
        return whole
    first = max(whole[0], math.floor(min(begin for begin, _end in ranges)))
    last = min(whole[1], math.ceil(max(end for _begin, end in ranges)))
    return (first, last) if first <= last else whole


def lone_keys(datablocks):
    """{frame} of the keyframes of the datablocks that have none in the frames beside them: poses, and not a capture."""
    keyed = set()
    for each in datablocks:
        for curve in compat.curves_to_read(each) or ():
            keyed.update(actions.keys_of(curve)[0].tolist())
    return {frame for frame in keyed if keyed.isdisjoint((frame - 1.0, frame + 1.0))}


def movers(objects):
    """The objects, and those that they hang on or follow by parents and constraints, also of bones; each once."""
    found, ahead = [], list(objects)
    while ahead:
        each = ahead.pop()
        if each is None or each in found:
            continue
        found.append(each)
        constraints = list(each.constraints)
        if each.pose is not None:
            constraints += [constraint for bone in each.pose.bones for constraint in bone.constraints]
        ahead += [each.parent, *(getattr(constraint, "target", None) for constraint in constraints)]
    return found


def visit(scene, times, read):
    """Generator that calls read() at every frame in turn, as physics needs it, and yields the share done. Returns what
    read() returned. The frame that was current is so again, come what may. @throws SceneError, with the frame."""
    name, former, is_closed = scene.name, (scene.frame_current, scene.frame_subframe), False
    rows = []
    try:
        for frame in times:
            scene = bpy.data.scenes.get(name)
            if scene is None:
                raise SceneError(f"The scene '{name}' is gone. Try again")
            whole = math.floor(frame)
            scene.frame_set(whole, subframe=float(frame - whole))
            try:
                rows.append(read())
            except SceneError as error:
                raise SceneError(f"At frame {wording.frame(frame)}: {error}") from error
            yield len(rows) / len(times)
    except GeneratorExit:
        is_closed = True
        raise
    finally:
        scene = bpy.data.scenes.get(name)
        if scene is not None and is_closed:  # perhaps Blender closes the file: nothing may be evaluated any more
            scene.frame_current, scene.frame_subframe = former
        elif scene is not None:
            scene.frame_set(former[0], subframe=former[1])
    return rows
