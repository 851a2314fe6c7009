# SPDX-License-Identifier: GPL-3.0-or-later
"""Which marker is where on the body: sets that laboratories use, recognised by their names.

A label may begin with a subject: the person or thing that wears the marker.
"""

import os.path
import re
from typing import NamedTuple

from .known_sets import BUILT_IN, key_of
from .landmarks import has_joints

#: How a subject is put before a name: "Subject:LASI", "Subject_LASI", "Skeleton 001_LASI".
SUBJECTS = (r"(.*:)(.*)", *(rf"((?:[^:_ ]+[_ ]){{{words}}})(.+)" for words in (1, 2, 3)))


class Recognition(NamedTuple):
    """The landmark of each label that was asked for, or None; numbers of labels that props or another person wear."""

    landmarks: tuple
    others: tuple


def recognise(labels, is_skeleton=False):
    """The `Recognition` of labels by the set that knows most of them. is_skeleton: they are known to be joints.

    Else names are of joints only if most of them are. Landmarks are not given twice: of two labels for one, that
    is known which the set has first, else the shorter.
    """
    best = Recognition((None,) * len(labels), ())
    most = sorted(labels)[len(labels) // 4 : 1 + 3 * len(labels) // 4]  # they begin alike: "mixamorigHips"
    for pattern in (*SUBJECTS, f"({re.escape(os.path.commonprefix(most))})(.+)"):
        parts = [re.fullmatch(pattern, label, re.DOTALL) or ("", "", label) for label in labels]
        for marker_set in BUILT_IN:
            found = _of_one(marker_set, [part[1] for part in parts], [part[2] for part in parts])
            is_possible = has_joints(found.landmarks) or is_skeleton == has_joints(marker_set.values())
            if is_possible and found.landmarks.count(None) < best.landmarks.count(None):
                best = found
    return best


def _of_one(marker_set, subjects, names):
    """The Recognition of one person: the subject of which most is known, and those with what he has not (gloves)."""
    keys, rank = [key_of(name) for name in names], {key: number for number, key in enumerate(marker_set)}
    known = [marker_set.get(key) for key in keys]
    members, found, others, taken = {}, [None] * len(names), [], set()
    for number in sorted(range(len(names)), key=lambda number: (rank.get(keys[number], 0), len(names[number]))):
        members.setdefault(subjects[number], []).append(number)
    of_each = [(subject, numbers, {known[k] for k in numbers} - {None}) for subject, numbers in members.items()]
    for subject, numbers, own in sorted(of_each, key=lambda each: -len(each[2])):
        if taken and (own & taken or (subject and not own)):
            others += numbers
            continue
        for number in numbers:
            free = [place for place in (known[number] or "").split() if place not in taken]
            found[number] = free[0] if free else None
            taken.update(free[:1])
    return Recognition(tuple(found), tuple(others))
