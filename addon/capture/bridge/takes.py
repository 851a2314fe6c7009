# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes in the scene: a collection with one Empty for each marker, animated as it was recorded.

The Empties are the artist's to mend: what is read back is what their keys say.
"""

import math
from dataclasses import dataclass

import bpy
import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene import actions, pose_objects, subject
from ...scene.core import sample_times
from ..core import units

#: Size of a marker, as a share of the extent of the whole set, and where that has none, in meters.
SIZE_OVER_EXTENT = 0.01
LEAST_SIZE = 0.002

#: How far from its samples a key may lie, as a share of the time between them.
OFF_SAMPLE = 0.2


NOT_CHOSEN = "No take is chosen. Import a motion capture file, and choose its collection as Take"


@dataclass(frozen=True, eq=False)
class Recording:
    """What the Empties of a take say."""

    name: str  # of the take
    labels: tuple  # m names, as in the file
    empties: tuple  # their m objects; not to be kept
    positions: np.ndarray  # (f, m, 3) float64, world space; NaN where a marker has no key
    frames: np.ndarray  # (f,) float64, of the scene
    rate_hz: float  # samples a second, as recorded


def make(take, frames, scale=1.0):
    """The collection of a core.capture.Take: samples at `frames` (f,) of the scene, positions times `scale`.

    Markers that are never seen get no Empty. What was made before an error is taken away again.
    """
    collection = bpy.data.collections.new(take.name)
    try:
        bpy.context.scene.collection.children.link(collection)
        collection.meanvalue.is_take = True
        collection.meanvalue.is_skeleton = take.is_skeleton
        collection.meanvalue.rate_hz = take.rate_hz
        collection.meanvalue.sample_count = take.frames
        collection.meanvalue.frames_per_sample = float(frames[1] - frames[0]) if len(frames) > 1 else 1.0
        collection.meanvalue.fullest_frame = frames[int(take.measured.sum(axis=1).argmax())]
        collection.meanvalue.missing_share = take.missing_share
        positions = take.positions * scale
        measured = take.measured
        size = max(SIZE_OVER_EXTENT * units.median_extent(positions), LEAST_SIZE)
        for number in np.flatnonzero(measured.any(axis=0)):
            empty = bpy.data.objects.new(take.labels[number], None)
            collection.objects.link(empty)
            empty.empty_display_type, empty.empty_display_size = 'SPHERE', size
            empty.meanvalue.marker = take.labels[number]
            animate(empty, positions[:, number], frames)
    except BaseException:
        remove(collection)
        raise
    return collection


def remove(collection):
    """Deletes a take with its Empties and their actions."""
    for empty in list(collection.objects):
        actions.remove_action(empty)
        bpy.data.objects.remove(empty)
    bpy.data.collections.remove(collection)


def markers(collection):
    """The Empties of a take, in the order of the file; of one that was duplicated the first."""
    found = {}
    for obj in collection.objects:
        if obj.meanvalue.marker:
            found.setdefault(obj.meanvalue.marker, obj)
    return list(found.values())


def is_take(collection):
    return collection is not None and collection.meanvalue.is_take


def of_marker(obj):
    """The take that an Empty is a marker of, or None."""
    if obj is None or not obj.meanvalue.marker:
        return None
    return next((collection for collection in obj.users_collection if is_take(collection)), None)


def chosen(context):
    """The take that the artist works on: of the active marker, else of the active mesh, else the only one; or None."""
    active = pose_objects.of(context.object) or context.object
    meshes = [] if active is None else [active, *([active.parent] if active.parent else [])]
    own = next(filter(None, [of_marker(active), *(each.meanvalue.capture.take for each in meshes)]), None)
    found = [collection for collection in bpy.data.collections if is_take(collection)]
    return own or (found[0] if len(found) == 1 else None)


def read(collection):
    """The Recording of a take. @throws SceneError if there is nothing to read, or its keys were stretched in time."""
    if not is_take(collection):
        raise SceneError(NOT_CHOSEN)
    empties = markers(collection)
    positions, frames = _keyed(collection, empties)
    for number, empty in enumerate(empties):  # as their parents, if any, have them now
        if empty.parent is not None or empty.constraints:
            around = np.array(empty.matrix_world @ empty.matrix_basis.inverted(), np.float64)
            positions[:, number] = positions[:, number] @ around[:3, :3].T + around[:3, 3]
    return Recording(
        name=collection.name,
        labels=tuple(empty.meanvalue.marker for empty in empties),
        empties=tuple(empties),
        positions=positions,
        frames=frames,
        rate_hz=collection.meanvalue.rate_hz,
    )


def _keyed(collection, empties):
    """((f, m, 3) where the keys of the m Empties are, NaN for what has none in any of the three; (f,) frames)."""
    curves = [[actions.read_keys(empty, "location", index) for index in range(3)] for empty in empties]
    spans = [(frames.min(), frames.max()) for curve in curves for frames, _ in curve if len(frames)]
    if not spans:
        raise SceneError(f"The take '{collection.name}' has no markers with keyframes any more. Import it again")
    spacing = collection.meanvalue.frames_per_sample
    first, last = min(span[0] for span in spans), max(span[1] for span in spans)
    count = round((last - first) / spacing) + 1
    if count > collection.meanvalue.sample_count:
        raise _stretched(collection, f"The keys of '{collection.name}' reach over {count:,} samples")
    positions = np.full((count, len(empties), 3), np.nan)
    for number, curve in enumerate(curves):
        for index, (frames, values) in enumerate(curve):
            samples = (frames - first) / spacing
            numbers = np.rint(samples).astype(int)
            if off := np.count_nonzero(np.abs(samples - numbers) > OFF_SAMPLE):
                what = f"{wording.counted(off, 'key')} of marker '{empties[number].name}' are off the samples"
                raise _stretched(collection, what)
            positions[numbers, number, index] = values
    positions[np.isnan(positions).any(axis=2)] = np.nan  # all three or none
    return positions, first + spacing * np.arange(count)


def swap(collection, one, other, frame):
    """Gives two Empties of a take each other's path, from a frame of the scene on. @throws SceneError."""
    if one.parent != other.parent:
        raise SceneError(f"'{one.name}' and '{other.name}' have different parents. Clear them (Alt P)")
    empties = markers(collection)
    positions, frames = _keyed(collection, empties)
    pair = [empties.index(one), empties.index(other)]
    later = np.flatnonzero(frames >= frame - 0.5 * collection.meanvalue.frames_per_sample)[:, None]
    positions[later, pair] = positions[later, pair[::-1]]
    for number in pair:
        animate(empties[number], positions[:, number], frames)


def active_problem(settings):
    """The problem of a take's settings whose line the artist chose, or None."""
    return settings.problems[settings.active_problem] if 0 <= settings.active_problem < len(settings.problems) else None


def go_to_problem(collection):
    """To the frame of the problem whose line the artist chose, with its marker selected."""
    problem, context = active_problem(collection.meanvalue), bpy.context
    if problem is None:
        return
    whole = math.floor(problem.frame)
    context.scene.frame_set(whole, subframe=problem.frame - whole)
    if context.mode == 'OBJECT' and problem.marker is not None and problem.marker.name in context.view_layer.objects:
        subject.choose(problem.marker)


def animate(mover, positions, frames, ramp=0):
    """Keys where an object goes: positions (f, 3), NaN where nobody knows. There its influence is 0, and it fades over
    `ramp` samples before and after."""
    present = ~np.isnan(positions).any(axis=1)
    actions.write_vector(mover, "location", frames[present], positions[present])
    keyed, values = sample_times.changing_keys(sample_times.ramps(present, ramp), frames)
    actions.write_curve(mover, "meanvalue.influence", 0, keyed, values, 'LINEAR' if ramp else 'CONSTANT')
    if len(keyed) == 0:
        mover.meanvalue.influence = 1.0
    if present.any():
        mover.location = positions[int(present.argmax())]


def _stretched(collection, what):
    settings = collection.meanvalue
    return SceneError(
        f"{what}, but the take has {wording.counted(settings.sample_count, 'sample')}, one every "
        f"{settings.frames_per_sample:.4g} frames. Undo what stretched them, or import the take again"
    )
