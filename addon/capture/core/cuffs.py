# SPDX-License-Identifier: GPL-3.0-or-later
"""Rings of skin that go along with a limb: markers are on one side of it, and nothing else holds the other.

Between hip and knee skin as thick as the bone is short spreads the bend of both joints over the whole thigh. A *cuff*
is a few vertices around the middle of a limb's segment that move rigidly, as the markers of the segment do.
"""

from dataclasses import dataclass

import numpy as np

from ...scene.core import checks
from ...scene.core.rigid import fit_rotations
from . import landmarks as places
from .gaps import distance_variation
from .hip_centres import with_hips
from .rings import ring_around

#: Segments of the body that are stiff, long and bent far at both ends.
LIMBS = ("thigh", "shank")
#: Markers without a known place: distances that vary (standard deviation) by less than this share are rigid.
STIFF = 0.02
#: Radians that a segment's roll may be off: how badly its markers fit it, over how far they are from its axis.
ROLL = 0.3
#: Vertices of a cuff; how thick (radius) a segment may be over the length that its markers span; radians of its round
#: that markers must leave bare for it to need a cuff.
COUNT, THICKEST, BARE = 3, 0.3, 2.1


@dataclass(frozen=True, eq=False)
class Cuff:
    """Vertices that move as one. f frames; NaN where the markers that tell are away.

    segment  of the body, or "" where that is not known; markers  numbers of those that carry it; vertices  (k,);
    centre  (3,) of these at rest; radius of the limb there; turns  (f, 3, 3) from the rest; centres  (f, 3).
    """

    segment: str
    markers: tuple
    vertices: np.ndarray
    centre: np.ndarray
    radius: float
    turns: np.ndarray
    centres: np.ndarray


def find_cuffs(markers, reference, landmarks, anchors, vertices, triangles):
    """([Cuff], {segment: its `roll_error`}) of limbs whose markers tell how they turn, and of those whose do not.

    Which markers are of one segment is known from their landmarks, and else from the capture: their distances stay.
    That they do is asked of both. Where the best rigid motion (Kabsch 1976) is off by more than ROLL of how far they
    are from the segment's axis (by their second singular value), its roll is not known, and it gets no cuff.

    markers  (f, m, 3) aligned, retargeted, NaN where missing; reference  (m, 3) the same on the mesh at rest, without
    NaN; landmarks  m names or None; anchors  (m,) vertices that they carry; vertices  (n, 3); triangles  (t, 3).
    """
    markers = checks.motion(markers, "the markers")
    if places.has_joints(landmarks):
        return [], {}  # they are inside, nearly in one line
    # Hips, which go with the pelvis, are the third point of thighs that have two markers.
    rest, _, moving, names = with_hips(reference, reference, markers, landmarks)
    cuffs, refused, taken = [], {}, set(np.asarray(anchors).tolist())
    for name, members in _segments(names, rest, moving):
        segment = _Segment(members, rest, moving)
        if name and not segment.tells_roll:
            refused[name] = segment.roll_error
        if not segment.tells_roll:
            continue
        held = vertices[[anchors[k] for k in members if k < len(anchors)]]
        ring = ring_around(segment.middle, segment.axis, vertices, triangles, held)
        if ring is None or ring.radius > THICKEST * segment.length or ring.bare < BARE:
            continue  # no limb but a trunk or a head; or held all round
        chosen = ring.spread(COUNT, taken)
        if len(chosen) == COUNT:
            taken |= set(chosen)
            centre = vertices[chosen].mean(axis=0)
            motion = segment.carry(centre)
            cuffs.append(Cuff(name, tuple(members), np.array(chosen), centre, ring.radius, *motion))
    return cuffs, refused


def _segments(names, rest, moving):
    """[(segment or "", numbers of at least three markers)]."""
    known = sorted(places.segments(names).items())
    result = [(segment, numbers) for segment, numbers in known if segment.split(".")[0] in LIMBS]
    unknown = np.array([k for k, name in enumerate(names) if not places.segments_of(name)], int)
    result += [("", unknown[numbers].tolist()) for numbers in _stiff_sets(moving[:, unknown], rest[unknown])]
    return [(segment, numbers) for segment, numbers in result if len(numbers) > 2]


def _stiff_sets(moving, rest):
    """[marker numbers]: sets of markers (f, m, 3) all of whose distances stay, the stiffest first. rest  (m, 3).

    Each is grown from two markers that are in no set yet; what is at a joint may be in two.
    """
    if len(rest) < 3:
        return []
    sizes = np.linalg.norm(rest[:, None] - rest, axis=2)
    varies = distance_variation(moving) / np.maximum(sizes, 1e-300)
    left, result = set(range(len(rest))), []
    while len(left) > 1:
        numbers = sorted(left)
        first, second = np.unravel_index(varies[np.ix_(numbers, numbers)].argmin(), (len(numbers),) * 2)
        found = [numbers[first], numbers[second]]
        while len(found) < len(rest):
            worst = varies[:, found].max(axis=1)  # infinite for those that are in it
            if not worst.min() < STIFF:
                break
            found.append(int(worst.argmin()))
        left -= set(found)
        result.append(sorted(found))
    return result


class _Segment:
    """Markers `members` that move as one, of rest (m, 3) and moving (f, m, 3).

    axis (3,) that they are spread along, over `length`; middle (3,) of that; roll_error in radians.
    """

    def __init__(self, members, rest, moving):
        self._rest, self._moving = rest[members], moving[:, members]
        centre = self._rest.mean(axis=0)
        self.axis = np.linalg.svd(self._rest - centre)[2][0]
        along = (self._rest - centre) @ self.axis
        self.length = float(np.ptp(along))
        self.middle = centre + 0.5 * (along.min() + along.max()) * self.axis
        known = ~np.isnan(self._moving[..., 0])
        shares = known / np.maximum(known.sum(axis=1, keepdims=True), 1)
        self._turns = fit_rotations(self._rest, self._moving)
        self._rest_centres = shares @ self._rest
        self._centres = np.einsum("fk,fkj->fj", shares, np.nan_to_num(self._moving))
        off = self._off(known)
        self.roll_error = off / max(_across(self._rest), 1e-300)
        patterns, which = np.unique(known, axis=0, return_inverse=True)
        across = np.array([_across(self._rest[pattern]) for pattern in patterns])
        self._is_told = (across * ROLL > off)[which.ravel()]

    @property
    def tells_roll(self):
        return self.roll_error < ROLL and self._is_told.any()

    def carry(self, point):
        """((f, 3, 3) turns, (f, 3) where a point of the rest goes); NaN where too few markers are seen."""
        turns = np.where(self._is_told[:, None, None], self._turns, np.nan)
        return turns, self._centres + np.einsum("fij,fj->fi", turns, point - self._rest_centres)

    def _off(self, known):
        """How far the markers are from where they would be carried, rms over the frames in which all are seen."""
        whole = known.all(axis=1)
        if not whole.any():
            return np.inf
        away = self._rest - self._rest.mean(axis=0)
        carried = self._centres[whole, None] + np.einsum("fij,kj->fki", self._turns[whole], away)
        return float(np.sqrt(((self._moving[whole] - carried) ** 2).sum(axis=2).mean()))


def _across(points):
    """How far points (k, 3) are from the line through them (rms); 0 for less than three."""
    if len(points) < 3:
        return 0.0
    return np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1] / np.sqrt(len(points))
