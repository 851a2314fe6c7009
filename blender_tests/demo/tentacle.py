# SPDX-License-Identifier: GPL-3.0-or-later
"""One tentacle: its centre line, its cross sections, its tube of quads and its suckers. No bpy."""

from dataclasses import dataclass

import numpy as np

# Cross-section directions in degrees from the tentacle's upper side, one per vertex of the ten-sided
# tube, counter-clockwise seen from the tip. The two columns of quads beside 180 degrees are the widest:
# they carry the suckers.
SECTION_ANGLE_DEG = np.array([66.0, 98.0, 130.0, 180.0, -130.0, -98.0, -66.0, -32.0, 0.0, 32.0])
SUCKER_COLUMNS = (2, 3)

SAMPLES = 2000  # integration steps along a centre line


@dataclass(frozen=True)
class TentacleShape:
    """How one tentacle lies. Lengths in object units, angles in radians, `s` runs 0..1 from root to tip."""

    heading: float  # azimuth of the root's direction
    length: float
    root_radius: float
    tip_radius: float
    root_height: float
    sway: float  # amplitude of the sideways waves on the ground
    sway_phase: float
    curl_up: float  # how far the tip rolls upwards
    curl_side: float  # how far the tip rolls sideways
    curl_start: float = 0.6  # s where the roll begins


@dataclass(frozen=True)
class CentreLine:
    """Samples at `s` (k,): position, tangent, upper and side direction, each (k, 3); radius (k,)."""

    s: np.ndarray
    position: np.ndarray
    tangent: np.ndarray
    upper: np.ndarray
    side: np.ndarray
    radius: np.ndarray


def smoothstep(low, high, x):
    """0 below `low`, 1 above `high`, a cubic between."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def centre_line(shape, root):
    """The centre line from the point `root` (3,), by integrating a pitch and a yaw along the length."""
    s = np.linspace(0.0, 1.0, SAMPLES)
    radius = shape.tip_radius + (shape.root_radius - shape.tip_radius) * (1.0 - s) ** 1.15
    resting = shape.root_height + (radius * 0.8 - shape.root_height) * smoothstep(0.02, 0.42, s)
    rolled = smoothstep(shape.curl_start, 1.0, s) * (s - shape.curl_start) / (1.0 - shape.curl_start)
    pitch = np.arcsin(np.clip(np.gradient(resting, s) / shape.length, -0.9, 0.9)) + shape.curl_up * rolled
    waves = np.sin(2.0 * np.pi * (0.9 * s) + shape.sway_phase) - np.sin(shape.sway_phase)
    yaw = shape.heading + shape.sway * waves * smoothstep(0.0, 0.3, s) + shape.curl_side * rolled

    tangent = np.stack([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), np.sin(pitch)], axis=1)
    # Built from pitch and yaw rather than from the curvature, so that the sucker side never twists.
    upper = np.stack([-np.sin(pitch) * np.cos(yaw), -np.sin(pitch) * np.sin(yaw), np.cos(pitch)], axis=1)
    position = np.asarray(root) + np.cumsum(tangent, axis=0) * (shape.length / SAMPLES)
    return CentreLine(s, position, tangent, upper, np.cross(tangent, upper), radius)


def ring_parameters(line, ring_count):
    """`ring_count` values of s, spaced in proportion to the radius so that quads stay square."""
    density = np.cumsum(1.0 / line.radius)
    density = (density - density[0]) / (density[-1] - density[0])
    return np.interp(np.linspace(0.0, 1.0, ring_count + 1)[1:], density, line.s)


def section(line, s):
    """The ten vertices of the cross section at `s`, (10, 3), in the order of SECTION_ANGLE_DEG."""
    sample = min(round(s * (SAMPLES - 1)), SAMPLES - 1)
    angle = np.radians(SECTION_ANGLE_DEG)[:, None]
    height = np.where(np.cos(angle) < 0.0, 0.85, 1.0) * np.cos(angle)  # the sucker side is flatter
    offset = height * line.upper[sample] + np.sin(angle) * line.side[sample]
    # A cage lies outside the surface that subdivision makes of it; 1.12 gives back what it shrinks.
    return line.position[sample] + 1.12 * line.radius[sample] * offset


def add_tentacle(cage, root_loop, line, limb, ring_count, skin_part, sucker_part):
    """Extrudes the ten-vertex `root_loop` of the cage along `line`, caps it and sets its suckers."""
    loop = root_loop
    for ring, s in enumerate(ring_parameters(line, ring_count)):
        next_loop = cage.add_vertices(section(line, s), along=s)
        tube = cage.bridge(loop, next_loop, skin_part, limb)
        if 2 <= ring < ring_count - 3:  # the root has no room, the tip no size, for a sucker
            add_sucker(cage, tube[SUCKER_COLUMNS[ring % 2]], sucker_part)
        loop = next_loop
    tip = line.position[-1] + 0.8 * line.radius[-1] * line.tangent[-1]
    cage.cap(loop, tip, along=1.0, part=skin_part, limb=limb)


def add_sucker(cage, quad_index, sucker_part):
    """A cup on one quad: a raised rim and a sunk middle."""
    rim = cage.inset(quad_index, scale=0.86, height=0.34, part=sucker_part)
    cage.inset(rim, scale=0.50, height=-0.30, part=sucker_part)
