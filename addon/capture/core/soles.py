# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuffs, rings of skin that go along with a limb: markers are on one side of it, and nothing else holds the other.
Between hip and knee skin as thick as the bone is short spreads the bend of both joints over the whole thigh.

And soles of the mesh on a floor: markers are above them, and tell neither how high they are nor that toes bend."""

from dataclasses import dataclass

import numpy as np

from ...scene.core.motion import fit_rotations, turns_between, unit
from ...scene.core.point_sets import parts
from ...scene.core.sample_times import runs
from . import landmarks as places
from .gaps import low_pass
from .proportions import carried, with_hips

#: Segments of the body that are stiff, long and bent far at both ends, and how strong their cuffs are: where hips are
#: is less sure than where markers are.
LIMBS = {"thigh": 0.85, "shank": 1.0}
#: Radians that a segment's roll may be off: how badly its markers fit it, over how far they are from its axis.
ROLL = 1.0
#: What each of these takes from the strength of a cuff.
DOUBT = 0.4
#: Where the two rings of a cuff are, from the middle, and how thick (radius) a segment may be: over the length that its
#: markers span. Vertices of a cuff: one ring does not hold how a limb is tilted.
RINGS, THICKEST, COUNT = (-0.15, 0.15), 0.3, 6


@dataclass(frozen=True, eq=False)
class Cuff:
    """Vertices that move as one over f frames; NaN where one of the markers that tell is away."""

    segment: str  # of the body
    vertices: np.ndarray  # (k,)
    centre: np.ndarray  # (3,) of these at rest
    radius: float  # of the limb there
    strength: float  # from 0 to 1, of the handle: less the farther the roll may be off
    turns: np.ndarray  # (f, 3, 3) from the rest
    centres: np.ndarray  # (f, 3)


def find_cuffs(markers, reference, landmarks, anchors, surface):
    """[Cuff] of limbs whose markers tell how they turn.

    Where the best rigid motion (Kabsch 1976) is off by more than ROLL of how far the markers are from the segment's
    axis, it gets none; below, the cuff is the softer.

    markers  (f, m, 3) NaN where missing; reference  (m, 3) the same on the mesh at rest; landmarks  m names or None;
    anchors  (m,) vertices that they carry; surface  the mesh's Surface.
    """
    # Hips, which go with the pelvis, are the third point of thighs that have two markers.
    rest, moving, names = with_hips(reference, markers, landmarks)
    cuffs, taken = [], set(np.asarray(anchors).tolist())
    vertices, triangles = surface.vertices, surface.triangles
    for name, members in sorted(places.segments(names).items()):
        if name.split(".")[0] not in LIMBS or len(members) < 3:
            continue
        points, middle = rest[members], rest[members].mean(axis=0)
        own = [k for k in members if k < len(anchors)]  # where hips are in a thigh is less sure than how they turn it
        _, (_, across, _), (axis, *_) = np.linalg.svd(points - middle)
        paths = moving[:, members]
        turns = fit_rotations(points, paths)
        turns[np.isnan(paths[..., 0]).any(axis=1)] = np.nan  # where one of them is missing
        squares = ((paths - carried(points, paths, turns)) ** 2).sum(axis=2)
        squares = squares[~np.isnan(squares[:, 0])]
        off = float(np.sqrt(squares.mean())) if len(squares) else np.inf
        error = off * np.sqrt(len(members)) / max(across, 1e-300)
        if not error < ROLL:
            continue
        along = (points - middle) @ axis
        middle = middle + 0.5 * (along.min() + along.max()) * axis
        span = np.ptp(along)
        rings = [ring_around(middle + share * span * axis, axis, vertices, triangles) for share in RINGS]
        radius = max(radius for _, _, radius in rings)
        if radius > THICKEST * span:
            continue  # no limb but a trunk
        free = np.setdiff1d(np.concatenate([numbers for numbers, _, _ in rings]), list(taken))
        chosen = free[spread(vertices[free], vertices[anchors[own]], COUNT)].tolist()
        if len(chosen) == COUNT:
            taken |= set(chosen)
            centre = vertices[chosen].mean(axis=0)
            centres = moving[:, own].mean(axis=1) + np.einsum("fij,j->fi", turns, centre - rest[own].mean(axis=0))
            strength = LIMBS[name.split(".")[0]] - DOUBT * error
            cuffs.append(Cuff(name, np.array(chosen), centre, radius, strength, turns, centres))
    return cuffs


def spread(points, held, count):
    """Numbers of at most `count` of points (p, 3), as far from each other and from `held` (h, 3) as can be."""
    chosen = []
    while len(chosen) < min(count, len(points)):
        others = np.concatenate([held, points[chosen]])
        apart = np.linalg.norm(points[:, None] - others, axis=2).min(axis=1, initial=np.inf)
        if not apart.max() > 0.0:
            break
        chosen.append(int(apart.argmax()))
    return chosen


def ring_around(middle, axis, vertices, triangles):
    """(numbers (k,), centre (3,), mean radius) of the vertices (n, 3) where the plane through `middle` (3,) across
    `axis` (3,) cuts the mesh's triangles (t, 3): of the nearest ring; an infinite radius where there is none."""
    is_above = (vertices - middle) @ axis > 0.0
    cut = triangles[is_above[triangles].any(axis=1) & ~is_above[triangles].all(axis=1)]
    part = parts(np.concatenate([cut[:, :2], cut[:, 1:]]), len(vertices))
    numbers = np.unique(cut)
    rings = []
    for first in np.unique(part[numbers]):
        around = numbers[part[numbers] == first]
        points = vertices[around]
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        rings.append((around, centre, float(np.linalg.norm(np.cross(axis, points - centre), axis=1).mean())))
    return min(rings, key=lambda ring: np.linalg.norm(ring[1] - middle), default=(numbers, middle, np.inf))


#: Body heights a second, and body heights above the ground: below both a marker stands. Feet also roll over heel or
#: toes: then they stand on some of their markers.
SLOW, LOW = 0.14, 0.05
#: Body heights that soles of who sits may be off the ground that the capture tells: feet on a rest are farther from it.
SEATED = 0.03
SHORTEST = 0.06  # seconds
SMOOTHING_HZ = 12.0  # speeds of noise are no speeds
#: Body heights: how far above its lowest point skin is of a sole, and how far from the foot's anchors.
SOLE, AROUND = 0.012, 0.07
#: Where toes begin, along the sole from the heel; vertices of a sole, and of toes, that move together.
BALL, HELD = 0.75, 14
#: Of a foot that stands: the least cosine between the way that its sole looks, and down.
DOWN = 0.3
#: Ways down, by columns: whatever way a foot is turned, the farthest along one of them is nearly the lowest.
WAYS_DOWN = np.array([(x, y, -1.0) for x in np.linspace(-3.0, 3.0, 25) for y in np.linspace(-3.0, 3.0, 25)]).T
#: How gently toes begin and cease to bend, as a share of the room below their joint.
SOFT = 0.4
UP, LEVEL = np.array([0.0, 0.0, 1.0]), np.array([1.0, 1.0, 0.0])


def find_stances(positions, rate_hz, height, slow=SLOW):
    """(f, k) bool: where each marker of a foot stands still on the ground: it is low and slow, and for long enough.

    "Low" is above the level that it has for a fiftieth of the time, or above the lowest marker in that frame: feet also
    stand on stairs, where each is the lower one for part of its stance.

    positions  (f, k, 3) meters, Z up, of both feet, NaN stands nowhere; rate_hz  frames a second; height  of the body;
    slow  a speed as SLOW.
    """
    smooth = low_pass(positions, rate_hz, SMOOTHING_HZ) if rate_hz > 3.0 * SMOOTHING_HZ else positions
    speed = np.linalg.norm(np.gradient(smooth, axis=0), axis=2) * rate_hz if len(smooth) > 1 else 0.0 * smooth[..., 0]
    lowest = np.fmin.reduce(smooth[..., 2], axis=1)
    result = np.zeros(positions.shape[:2], bool)
    for marker in np.flatnonzero(~np.isnan(speed).all(axis=0)):
        heights = smooth[:, marker, 2]
        ground = np.fmax(np.nanquantile(heights, 0.02), lowest)
        is_near = (speed[:, marker] < slow * height) & (heights - ground < LOW * height)
        for begin, end in runs(is_near):
            result[begin:end, marker] = end - begin >= SHORTEST * rate_hz
    return result


def standing(path, sample, landmarks, rate):
    """(m, 3): markers path (f, m, 3) at a sample, with legs as where they stand if their foot does not lie flat then.

    A leg is from where its foot lies flat and the pelvis is highest above it, turned about the upright axis and moved
    as the pelvis is. So a step of a walk, or on stairs, tells how the person stands.
    """
    result, segments = path[sample].copy(), [set(places.segments_of(name)) for name in landmarks]
    seen = [k for k, some in enumerate(segments) if some and not np.isnan(result[k, 0])]
    pelvis = [k for k in seen if "pelvis" in segments[k]]
    for side, foot in places.feet(landmarks).items() if len(pelvis) > 1 else ():
        own = {f"{part}.{side}" for part in ("thigh", "shank", "foot")}
        leg = [k for k in seen if own & segments[k] and k not in pelvis]
        flat = find_stances(path[:, foot], rate, np.ptp(result[seen, 2])).all(axis=1)
        rise = path[:, pelvis, 2].mean(axis=1) - path[:, leg, 2].mean(axis=1)
        rise = np.where(flat & ~np.isnan(rise), rise, -np.inf)
        if not flat[sample] and np.isfinite(rise.max()):
            then, now = path[[rise.argmax(), sample]][:, pelvis]
            turn = fit_rotations(then * LEVEL, now * LEVEL)
            result[leg] = now.mean(axis=0) + (path[rise.argmax(), leg] - then.mean(axis=0)) @ turn.T
    return result


def on_floor(markers, captured, anchors, body, level, rate, sits=False):
    """((f, m, 3), [Cuff]): markers with the soles of the mesh at the height `level` while feet stand; soles and toes.

    What touches the ground does not slide, unless it goes far. The mean of both feet moves the whole body. The floor is
    where soles are in most of the stances near the ground of the mesh; others stay as far from it (stairs, footrests).

    markers: their `path` (f, m, 3) aligned, retargeted, NaN where missing, `reference` (m, 3) on the Body at rest, and
    `landmarks`; captured  (f, m, 3) before that; anchors  (m,) vertices that they carry; rate  frames a second; sits:
    the reference is of who does not stand.
    """
    vertices, used = body.surface.vertices, np.unique(body.surface.triangles)
    low = np.setdiff1d(used[vertices[used, 2] - body.ground < SOLE * body.height], anchors)
    of_segments = places.segments(markers.landmarks)
    groups = [(foot, of_segments.get(f"foot.{side}", foot)) for side, foot in places.feet(markers.landmarks).items()]
    groups = [group for group in groups if len(group[1]) > 1]
    places_of = [vertices[anchors[members]] for _, members in groups]
    away = [np.linalg.norm(vertices[low, None] - held, axis=2).min(axis=1) for held in places_of]
    feet = []
    for (touching, members), apart in zip(groups, away, strict=True):
        sole = low[(apart < AROUND * body.height) & (apart == np.min(away, axis=0))]
        if len(sole):
            foot = _Foot(markers, anchors, touching, members, body, sole)
            stands = find_stances(captured[:, touching], rate, body.height).any(axis=1)
            foot.stands = stands & (foot.turns[:, 2, 2] > DOWN) & ~np.isnan(foot.lowest)
            feet.append(foot)
    feet = [foot for foot in feet if foot.stands.any()]
    if not feet:
        return markers.path, []
    heights = np.concatenate([foot.lowest[foot.stands] for foot in feet])
    reach = (SEATED if sits else LOW) * body.height
    is_near = np.abs(heights - body.ground) < reach
    floor = np.median(heights[is_near]) if is_near.any() else body.ground
    moves = [foot.moves(level, floor, reach) for foot in feet]
    of_body = np.mean(moves, axis=0)
    result = markers.path + of_body[:, None, :3]
    for foot, move in zip(feet, moves, strict=True):
        result[:, foot.touching] += (move - of_body)[:, None, :3]
    return result, [cuff for foot, move in zip(feet, moves, strict=True) for cuff in foot.laid(move, result, vertices)]


class _Foot:
    """One over f frames, which is rigid up to its ball. sole  (s,) vertices; the rest as of `on_floor()`."""

    def __init__(self, markers, anchors, touching, members, body, sole):
        vertices, landmarks, self.touching = body.surface.vertices, markers.landmarks, touching
        self.reference = markers.reference
        self.side = places.side_of(landmarks[members[0]])
        toes = [k for k in members if landmarks[k].startswith("toe")]
        behind = [k for k in members if k not in toes]
        way = np.zeros(3)  # nothing tells where its toes are
        if toes and behind:
            way = unit((vertices[anchors[toes]].mean(axis=0) - vertices[anchors[behind]].mean(axis=0)) * LEVEL)
        along, middle = vertices[sole] @ way, vertices[sole].mean(axis=0)
        begin = along.min() + BALL * np.ptp(along)
        self.ends = middle + np.outer([begin, along.max()] - middle @ way, way)
        self.ends[:, 2] = body.ground
        both = sole[along <= begin], sole[along > begin]
        self.parts = [part[spread(vertices[part], middle[None], HELD)] for part in both]
        self.on_toes = [k for k in toes if len(both[1]) and vertices[anchors[k]] @ way > begin]
        stiff = [k for k in members if k not in self.on_toes]
        rigid = stiff if len(stiff) > 2 else [k for k in members if "tip" not in landmarks[k]]
        rigid = rigid if len(rigid) > 1 else members
        outermost = np.unique((vertices[both[0]] @ WAYS_DOWN).argmax(axis=0))
        points = np.concatenate([markers.reference[rigid], self.ends[:1], vertices[both[0][outermost]]])
        self.turns = fit_rotations(markers.reference[rigid], markers.path[:, rigid])
        moved = carried(points, markers.path[:, rigid], self.turns)[:, len(rigid) :]
        self.ball, self.lowest = moved[:, 0], moved[..., 2].min(axis=1)
        # What touches the ground, from frame to frame.
        frames, steps, below = np.arange(len(moved) - 1), np.diff(moved[..., :2], axis=0), moved[..., 2].argmin(axis=1)
        steps = 0.5 * (steps[frames, below[:-1]] + steps[frames, below[1:]])
        self.slid = np.concatenate([np.zeros((1, 2)), np.nan_to_num(steps).cumsum(axis=0)])

    def moves(self, level, floor, reach):
        """(f, 4): what it has to be moved by, and how high the ground below it is then."""
        moves = np.zeros((len(self.ball), 4))
        for begin, end in runs(self.stands):
            own = np.median(self.lowest[begin:end])
            moves[begin:end, 3] = level + (0.0 if abs(own - floor) < reach else own - floor)
            moves[begin:end, 2] = moves[begin:end, 3] - self.lowest[begin:end]
            slid = self.slid[begin:end]
            if np.ptp(slid, axis=0).max() < reach:  # else it is meant to
                moves[begin:end, :2] = slid.mean(axis=0) - slid
        # Between stances cubics that begin and end level; flat outside.
        known = np.flatnonzero(self.stands)
        place = np.interp(np.arange(len(moves)), known, np.arange(len(known)))
        before, share = place.astype(int), (place % 1.0)[:, None]
        after = np.minimum(before + 1, len(known) - 1)
        return moves[known[before]] + share**2 * (3.0 - 2.0 * share) * (moves[known[after]] - moves[known[before]])

    def laid(self, moves, path, vertices):
        """The [Cuff]s of its sole and of its toes, which bend as far up as keeps them above the ground; markers on
        these go along, in path (f, m, 3)."""
        ball = self.ball + moves[:, :3]
        room = np.maximum(ball[:, 2] - moves[:, 3], 0.0)
        turns, way = np.where(np.isnan(room)[:, None, None], np.nan, self.turns), self.ends[1] - self.ends[0]
        ways, most = turns @ way, np.minimum(room, np.linalg.norm(way))
        rise = 0.5 * (ways[:, 2] - most + np.hypot(ways[:, 2] + most, SOFT * most))
        flat = unit(ways * LEVEL) * np.sqrt(np.maximum(way @ way - rise**2, 0.0))[:, None]
        bent = turns_between(ways, flat + rise[:, None] * UP) @ turns
        bends = ball[:, None] + np.einsum("fij,kj->fki", bent, self.reference[self.on_toes] - self.ends[0])
        path[:, self.on_toes] = np.where(np.isnan(bends + path[:, self.on_toes]), path[:, self.on_toes], bends)
        for name, some, turned in zip(("foot", "toes"), self.parts, (turns, bent), strict=True):
            if len(some):
                centre = vertices[some].mean(axis=0)
                centres = ball + np.einsum("fij,j->fi", turned, centre - self.ends[0])
                radius = np.linalg.norm(vertices[some] - centre, axis=1).max()
                yield Cuff(f"{name}.{self.side}", some, centre, radius, 1.0, turned, centres)
