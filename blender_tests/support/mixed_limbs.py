# SPDX-License-Identifier: GPL-3.0-or-later
"""Straight limbs with shape keys that bend and turn them."""

import bpy
import numpy as np

from . import bent_limb, installed, meshes, steps

DIAGONAL = float(np.hypot(bent_limb.LENGTH, 2.0 * bent_limb.RADIUS))


def limb(name="Limb", **shapes):
    """A straight limb with a shape key for each of `shapes`, {name: n x 3}."""
    rest, faces = bent_limb.limb()
    obj = meshes.make_object(rest.tolist(), faces, name)
    obj.shape_key_add(name="Basis")
    for key_name, shape in shapes.items():
        steps.add_key(obj, key_name, shape)
    return obj


def rest():
    return bent_limb.limb()[0]


def bending(degrees=140.0):
    return limb(Bend=bent_limb.bent(rest(), degrees))


def shown(obj):
    """n x 3: what Blender makes of the keys."""
    bpy.context.view_layer.update()
    return meshes.seen(obj).astype(np.float64)


def set_value(obj, name, value):
    obj.data.shape_keys.key_blocks[name].value = value
    bpy.context.view_layer.update()


def miss(obj, truth):
    """rms distance, after the best rigid fit: where a mix without anchors stands is not said by its shapes."""
    fit_rotations = installed.part("scene.core.motion").fit_rotations
    placed = shown(obj)
    rotation = fit_rotations(placed, truth)
    off = (placed - placed.mean(axis=0)) @ rotation.T - (truth - truth.mean(axis=0))
    return float(np.sqrt((off**2).sum(axis=1).mean()))


def linear_miss(degrees, share):
    straight = rest() + share * (bent_limb.bent(rest(), degrees) - rest())
    truth = bent_limb.bent(rest(), share * degrees)
    return float(np.sqrt((((straight - straight.mean(0)) - (truth - truth.mean(0))) ** 2).sum(axis=1).mean()))


def in_betweens_of(obj):
    """Names of the keys that Bake Mix has made: those that are driven."""
    animation = obj.data.shape_keys.animation_data
    paths = {curve.data_path for curve in animation.drivers} if animation else ()
    return [key.name for key in obj.data.shape_keys.key_blocks if key.path_from_id("value") in paths]


def bake(obj, share=0.2):
    obj.meanvalue.mix.tolerance_share = share
    steps.run(obj, "bake_mix")


def animate(obj, frames=12):
    key = obj.data.shape_keys.key_blocks["Bend"]
    for frame, value in ((1, 0.0), (frames, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, frames


def animated(tmp_path):
    """A limb with an animated mix, in a saved file."""
    obj = mixing()
    animate(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "mix.blend"))
    meshes.activate(obj)
    return obj


MIX = "Rotation-Aware Mix"


def keys_of(obj):
    return obj.data.shape_keys.key_blocks


def mixing(degrees=140.0, value=0.5):
    obj = bending(degrees)
    obj.meanvalue.mix.is_on = True
    set_value(obj, "Bend", value)
    return obj
