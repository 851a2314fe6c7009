# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes shape keys that stand for a rotation-aware mix, so that it plays without the add-on, and takes them back."""

import bpy

from ... import wording
from ...errors import SceneError
from ...widgets.background import BackgroundOperator
from ..bridge import in_between_keys, mixed_keys
from ..bridge.morphers import InBetweenSearch

#: Where the tolerance is not reached.
ADVICE = "Raise the tolerance, or bake the animation to a point cache"

#: In-between keys that are made at most.
MOST_KEYS = 60


def _problem(obj):
    """Why nothing can be baked, nor removed, in words, or None."""
    if obj.meanvalue.baked.target:
        return f"A bake of '{obj.name}' plays already. Press Remove Bake first"
    return None if mixed_keys.in_between_names(obj) else mixed_keys.problem(obj)


class MEANVALUE_OT_bake_mix(BackgroundOperator, bpy.types.Operator):
    """Make the in-between shape keys that the tolerance needs, driven by the sliders, to play without the add-on"""

    bl_label = "Bake Mix"
    switch = "remove"
    problems = (_problem,)
    doing = "Baking the mix of"

    remove: bpy.props.BoolProperty(
        name="Remove",
        description="Take away the in-between keys that are there. The sliders mix in straight lines then, or live",
        options={'SKIP_SAVE'},
    )

    def prepare(self, obj):
        if self.remove:
            return None
        mix_input = mixed_keys.gather(obj)
        tolerance = obj.meanvalue.mix.tolerance_share / 100.0 * mix_input.diagonal
        return InBetweenSearch(mix_input, tolerance, MOST_KEYS)

    def progress_text(self, stage, share):
        solved = self._prepared.solved if self._prepared is not None else 0
        if not solved:
            return super().progress_text(stage, share)
        return f"{wording.counted(solved, 'mix', 'mixes')} solved    Esc: Cancel"

    def finish(self, obj, prepared, found):
        if self.remove:
            count = in_between_keys.remove(obj)
            if count == 0:
                raise SceneError(f"'{obj.name}' has no in-between keys of Bake Mix")
            obj.data.update_tag()
            return f"Removed {wording.counted(count, 'in-between key')} of '{obj.name}'", []
        share = found.error / prepared.bind_input.diagonal if prepared.bind_input.diagonal else 0.0
        is_near = found.error <= prepared.tolerance
        if not found.shapes and not is_near:
            raise SceneError(f"No in-between key brings the mix of '{obj.name}' nearer than straight lines. {ADVICE}")
        if not found.shapes:
            text = f"No in-between keys are needed: in straight lines the mix is within {share:.2%} of the size"
            removed = in_between_keys.remove(obj)
            if not removed:
                raise SceneError(text)
            return text, [f"Removed {wording.counted(removed, 'key')} that stood for a former mix"]
        obj.meanvalue.mix.is_on = False
        made = wording.counted(len(in_between_keys.make(obj, prepared.bind_input, found)), "in-between key")
        text = f"'{obj.name}' has {made}, within {share:.2%} of the mesh's size, driven by its sliders"
        return text, [] if is_near else [f"That is more than the tolerance. {ADVICE}"]
