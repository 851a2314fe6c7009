# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples poses of the mesh's own rig, as examples of how it bends."""

import bpy

from ... import wording
from ...live import engine
from ...widgets.background import BackgroundOperator
from ..bridge import rig_poses


class MEANVALUE_OT_sample_rig_poses(BackgroundOperator, bpy.types.Operator):
    """Keep the poses of the animated rig that differ most as shape keys, in place of those sampled before, and pose \
the mesh like them. They stay muted: the rig would bend an unmuted one twice"""

    bl_label = "Sample Rig Poses"
    doing = "Sampling the rig of"
    problems = (rig_poses.problem,)

    count: bpy.props.IntProperty(
        name="Poses", description="How many poses to keep at most", default=8, min=1, soft_max=16, max=64
    )

    def prepare(self, obj):
        return rig_poses.RigPoses(obj, bpy.context.scene, self.count)

    def before(self, prepared):
        with engine.held():
            for share in prepared.sample(self.object):
                yield "going through the animation", share

    def finish(self, obj, prepared, _outcome):
        names = prepared.write(obj)
        poses = wording.counted(len(names), "pose")
        return f"'{obj.name}' is posed like {poses} of its rig: {wording.quoted(names, limit=8)}", []
