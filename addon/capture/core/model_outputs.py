# SPDX-License-Identifier: GPL-3.0-or-later
"""Which points of a file are no markers on the subject: angles, forces and points that a model computed.

A C3D file tells by parameters of its group POINT: ANGLES, FORCES, ... hold labels of points that are no positions. Axes
of body segments are not listed there, but show by what they are. TRC files have only names.
"""

from __future__ import annotations

import re

import numpy as np

from ...errors import MotionFileError

#: Parameter of POINT that lists labels -> what they are.
KINDS = {
    "ANGLES": "angles",
    "FORCES": "forces",
    "MOMENTS": "moments",
    "POWERS": "powers",
    "SCALARS": "scalars",
    "REACTIONS": "reactions",
    "MODELED_MARKERS": "virtual points",
    "MODELLED_MARKERS": "virtual points",
    "VIRTUAL_MARKERS": "virtual points",
    "BONES": "segment axes",
}
VIRTUAL = "virtual points"
UNLABELLED = "unlabelled points"

#: Names of points that no marker can be: joint centres, centre of mass, and V_ for virtual (Motion Analysis).
_VIRTUAL_NAME = re.compile(
    r"""(?: .*[:._\s] )?
        (?: cent(?:er|re)_?of_?mass(?:_?floor)? | com(?:_?floor)?
          | [lr]?[haksew]jc
          | .*joint[._\s]?cent(?:er|re) | .*(?:hip|knee|ankle|shoulder|elbow|wrist)[._\s]?joint(?:[._\s]?ground)?
          | v_.+ )""",
    re.IGNORECASE | re.VERBOSE,
)
_AXES = "OALP"


def numbered(parameters, name: str) -> list[str]:
    """`name` and its continuations, name2 and so on, as far as POINT has them."""
    present = set(parameters.names("POINT"))
    found = [name] if name in present else []
    number = 2
    while f"{name}{number}" in present:
        found.append(f"{name}{number}")
        number += 1
    return found


def in_c3d(parameters, labels: list[str]) -> list[str | None]:
    """For each label of a C3D file its kind, None for a marker."""
    kinds = dict(KINDS)
    types = parameters.strings("POINT", "TYPE_GROUPS")  # pairs: the parameter, and what one of it is called
    for name in types[0::2]:
        kinds.setdefault(name.upper(), name.lower())
    for name in ("LABELS", "DESCRIPTIONS", "UNITS", ""):
        kinds.pop(name, None)
    listed = {}
    for name, kind in kinds.items():
        for parameter in numbered(parameters, name):
            for label in parameters.strings("POINT", parameter):
                listed.setdefault(label, kind)
    listed.pop("", None)
    found = [listed.get(label) or _kind_by_name(label) for label in labels]
    if None not in found:  # where nobody gave names, points without are the markers
        found = [None if kind == UNLABELLED else kind for kind in found]
    return found


def _kind_by_name(label):
    if re.fullmatch(r"\*\d+", label):  # reflections that nobody gave to a marker are *1, *2, ... (Vicon)
        return UNLABELLED
    return VIRTUAL if is_virtual_name(label) else None


def is_virtual_name(label: str) -> bool:
    return len(label) < 100 and _VIRTUAL_NAME.fullmatch(label) is not None


def segment_axes(labels: list[str], positions: np.ndarray) -> np.ndarray:
    """(m,) bool: points that are origin and ends of the three axes of a body segment, as Plug-in Gait writes them.

    Four labels that differ in their last letter (O, A, L, P), and the three axes stand at right angles in every frame,
    which four markers on a body do not. `positions` (f, m, 3) in any unit.
    """
    number = {}
    for index, label in enumerate(labels):
        number.setdefault(label, index)
    found = np.zeros(len(labels), bool)
    positions = positions[:: max(1, positions.shape[0] // 100)]
    for stem in {label[:-1] for label in labels if len(label) > 1 and label[-1] == "O"}:
        members = [number.get(stem + letter) for letter in _AXES]
        if None not in members and _at_right_angles(positions[:, members]):
            found[members] = True
    return found


def _at_right_angles(four):
    """True if of (f, 4, 3) points the last three are at right angles seen from the first, in all frames with them."""
    four = four[np.isfinite(four).all(axis=(1, 2))]
    if len(four) == 0:
        return False
    with np.errstate(all="ignore"):
        axes = four[:, 1:] - four[:, :1]
        lengths = np.linalg.norm(axes, axis=2)
        axes = axes / lengths[..., None]
        cosines = np.abs(np.einsum("fij,fij->fi", axes, np.roll(axes, 1, axis=1)))
        return bool((lengths > 0.0).all() and (cosines < 1e-3).all())


def computed_from_others(labels: list[str], positions: np.ndarray) -> np.ndarray:
    """(m,) bool: named as a point on the ground or in the middle of others, and exactly so in every frame.

    For files without parameter groups. `positions` (f, m, 3) in the file's unit, with three decimals or more.
    """
    found = np.zeros(len(labels), bool)
    few = positions[:: max(1, positions.shape[0] // 20)]
    for index, label in enumerate(labels):
        if label.lower().endswith("ground"):
            found[index] = bool((few[:, index] == 0.0).all(axis=0).any())
    middles = [index for index, label in enumerate(labels) if re.match(r"(.*[:._\s])?mid", label[:100].lower())]
    if len(middles) * len(labels) ** 2 <= 2_000_000:  # a second; files of people are far below
        for index in middles:
            found[index] = _is_middle(few[:, index], np.delete(few, index, axis=1))
    return found


def _is_middle(here, others):
    """True if (f, 3) is within rounding the middle of two of (f, m, 3) in all frames."""
    if np.isnan(here).any():
        return False
    mirrored = 2.0 * here[:, None] - others
    tolerance = 1e-5 * (1.0 + np.abs(here).max())
    for index in range(others.shape[1]):
        distance = np.abs(others - mirrored[:, index : index + 1]).max(axis=(0, 2))
        distance[index] = np.inf
        if np.nanmin(np.where(np.isnan(distance), np.inf, distance)) <= tolerance:
            return True
    return False


def by_kind(labels: list[str], kinds: list[str | None]) -> dict[str, tuple[str, ...]]:
    """kind -> labels of that kind, in the file's order."""
    result = {}
    for label, kind in zip(labels, kinds, strict=True):
        if kind is not None:
            result.setdefault(kind, []).append(label)
    return {kind: tuple(names) for kind, names in result.items()}


def require_markers(labels: list[str], kinds: list[str | None], file: str) -> None:
    """Raises MotionFileError if there is no marker beside what a model computed."""
    if labels:
        return
    counts = ", ".join(f"{len(names)} {kind}" for kind, names in by_kind([""] * len(kinds), kinds).items())
    raise MotionFileError(
        f"{file}: it has no marker, only what a model computed ({counts}). Export the take with its marker trajectories"
    )
