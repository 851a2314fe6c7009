# SPDX-License-Identifier: GPL-3.0-or-later
"""Which frames are baked."""

from ...scene import bakeable, frames
from ..core import bake_times
from . import handle_source


def times_of(scene, obj, options):
    """f float64: the frames to sample. @throws SceneError."""
    first, last = options.frame_start, options.frame_end
    if options.frame_range == 'SCENE':
        first, last = scene.frame_start, scene.frame_end
    elif options.frame_range == 'ANIMATION':
        first, last = frames.moved_range(scene, (bakeable.of(obj) or handle_source).animated(obj))
    return bake_times.sample_times(first, last, options.step, options.samples)
