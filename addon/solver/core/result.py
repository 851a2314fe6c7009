# SPDX-License-Identifier: GPL-3.0-or-later
"""What a solve gives back to the scene: the positions to write and the words to say."""

import numpy as np

from ... import wording


def compose(bind_input, targets, solved):
    """n x 3 float32 for the result key.

    Free vertices are where the solver put them, and so are copies of hard anchors. What is fixed is copied, not
    converted there and back, so it keeps its bits: hard anchors those of their targets (k x 3) as far as mirroring and
    merging let them go there, all else those of the rest shape.
    """
    positions = np.array(solved, np.float32)
    positions[bind_input.fixed] = bind_input.rest.take(bind_input.fixed, axis=0)
    positions[bind_input.hard_vertices] = bind_input.solver_mesh.met(targets)[bind_input.hard_anchors]
    return positions


#: An anchor farther from its target than this share of the size is told of.
VISIBLE_MISS = 1e-4


def pose_warnings(bind_input, targets):
    """Sentences on k x 3 `targets` that cannot give what the artist may expect of them."""
    moved = (targets != bind_input.anchor_rest).any(axis=1)
    if not moved.any():
        yield "No handle has been moved, so the result is the rest shape"
    yield from torn_notes(bind_input, targets)


def torn_notes(bind_input, targets):
    """Sentences on k x 3 `targets` that move anchors which nothing can follow, or which cannot go there, and on why."""
    yield from bind_input.notes
    moved = (targets != bind_input.anchor_rest).any(axis=1)
    torn = np.count_nonzero(moved & ~bind_input.roi[bind_input.anchors])
    if torn:
        yield f"{wording.vertices(torn)} of moved handles lie outside the region, where nothing follows. Extend it"
    missed = np.abs(bind_input.solver_mesh.met(targets) - targets).max(axis=1, initial=0.0)
    is_hard = True if bind_input.strengths is None else np.isinf(bind_input.strengths)
    kept_back = np.count_nonzero(is_hard & (missed > VISIBLE_MISS * bind_input.diagonal))
    if kept_back:
        yield f"Mirroring, or another handle in one place, keeps {wording.vertices(kept_back)} away. Turn one off"


def unheld_notes(report, places):
    """A sentence on parts of the mesh that too little holds. report: the native one of a binding; places: n int, which
    of its vertices are those of the mesh."""
    numbers = [number for number in np.unique(np.asarray(report.part_of)[places]) if number >= 0]
    parts = [report.components[number] for number in numbers if report.carriers[number] < 0]
    count = sum(1 for part in parts if part.free_count and part.undetermined)
    if count:
        has = f"{wording.counted(count, 'part')} of the mesh {'has' if count == 1 else 'have'}"
        yield f"{has} fewer than three fixed points. Pin three of each, not in one line"


def nothing_is_held(report):
    """True if no part with free vertices has enough fixed points: a solve could move nothing."""
    parts = [part for part in report.components if part.free_count]
    return bool(parts) and all(part.undetermined for part in parts)
