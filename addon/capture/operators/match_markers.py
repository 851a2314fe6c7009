# SPDX-License-Identifier: GPL-3.0-or-later
"""Has the mesh carried by the markers of a take."""

import bpy

from ... import wording
from ...errors import ChangedMeanwhileError, SceneError
from ...posing.bridge import members, scene_input, targets
from ...scene import shape_keys
from ...widgets.background import BackgroundOperator
from ..bridge import marker_handles, marker_matching, marker_pairs, match_input


class MEANVALUE_OT_match_markers(BackgroundOperator, bpy.types.Operator):
    """Lay the markers of the reference frame on the mesh, give each its point, and have soft handles follow them"""

    bl_label = "Match Markers"
    doing = "Matching markers to"
    problems = (match_input.problem,)

    def _all_steps(self):
        """In place of a job: numpy's work goes on between looks at the interface, so that Esc is heard."""
        given = match_input.read(self.object())
        facts = match_input.facts(self.object(), given)
        matched = yield from marker_matching.steps(given)
        obj = self.object()
        if match_input.facts(obj, match_input.read(obj)) != facts:
            raise ChangedMeanwhileError(obj.name)
        return self._write(obj, matched)

    def _write(self, obj, matched):
        marker_handles.update_handles(obj, matched)
        notes = [*matched.notes, *_shared(obj, matched)]
        try:
            scene_input.gather(obj)
        except SceneError as problem:  # there is more to do before it can be posed
            notes.append(str(problem))
        if obj.meanvalue.baked.target:
            notes.append(shape_keys.BAKE_PLAYS)
        return _account(obj, matched), notes


def _shared(obj, matched):
    """Notes on vertices that another handle of the mesh has, too: the first of the list carries them."""
    own = {pair.control for pair in marker_pairs.matched(obj)}
    handles = [handle for handle in targets.enabled_handles(obj) if handle.control not in own]
    held = {}
    for handle, vertices in zip(handles, members.of(obj, handles), strict=True):
        held.update(dict.fromkeys(vertices.tolist(), handle.name))
    places = zip(matched.names, matched.vertices.tolist(), strict=True)
    both = {name: held[vertex] for name, vertex in places if vertex in held}
    if not both:
        return []
    return [
        f"{wording.quoted(both)} belong to vertices that {wording.quoted(sorted(set(both.values())))} has too: what "
        "comes first in the list of handles carries them. Remove or turn off one of the two"
    ]


def _account(obj, matched):
    follows = obj.meanvalue.live or obj.meanvalue.baked.target
    return [
        f"{wording.counted(len(matched.names), 'marker')} matched to '{obj.name}' at frame {matched.frame:g}"
        + ("" if follows else ". Press Live, or Bake"),
        f"They lie {_far(matched, matched.distance.mean())} from it on average, at most "
        f"{_far(matched, matched.distance.max())} ('{matched.names[int(matched.distance.argmax())]}')",
        *matched.told,
    ]


def _far(matched, distance):
    """A distance in the scene's unit and, since that may be any, over the mesh's size."""
    return f"{distance:.3g} ({wording.share(distance / matched.world_size)} of the mesh's size)"
