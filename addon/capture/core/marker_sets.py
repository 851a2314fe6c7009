# SPDX-License-Identifier: GPL-3.0-or-later
"""Which marker is where on the body: sets that laboratories use, recognised by their names.

A set is {label: landmark}.
"""

import re
from dataclasses import dataclass

from .known_sets import BUILT_IN


@dataclass(frozen=True)
class Recognition:
    """What `recognise()` found: the set that fits best and the landmark of each label that was asked for, or None."""

    name: str | None
    landmarks: tuple
    #: Labels that have a landmark, and landmarks of the set that nobody asked for.
    matched: int = 0
    absent: int = 0

    @property
    def words(self):
        """For the artist."""
        if self.name is None:
            return f"None of the {len(self.landmarks)} names is of a known marker set."
        rest = f"; {self.absent} of that set are not there" if self.absent else ""
        return f"{self.name}: {self.matched} of {len(self.landmarks)} names known{rest}."


def recognise(labels):
    """The `Recognition` of labels by the set that knows most of them.

    Of sets that know as many, the one with fewer absent markers. What all labels begin with, up to "_", is left out
    where that helps. Landmarks are not given twice: of two labels for one, the one that is written as the set has it
    is known, else the first.
    """
    labels = list(labels)
    prefix = re.match(r"(.+?_)", labels[0]) if len(labels) > 1 else None
    spellings = [labels]
    if prefix and all(label.startswith(prefix.group(1)) and label != prefix.group(1) for label in labels):
        spellings.append([label[len(prefix.group(1)) :] for label in labels])
    best = Recognition(None, (None,) * len(labels))
    for name, marker_set in BUILT_IN.items():
        for spelling in spellings:
            found = landmarks_of(marker_set, spelling)
            known = set(found) - {None}
            absent = len(set(marker_set.values()) - known)
            if known and (best.name is None or (len(known), -absent) > (best.matched, -best.absent)):
                best = Recognition(name, tuple(found), len(known), absent)
    return best


def landmarks_of(marker_set, labels):
    """[landmark or None] of the labels, however they are spelled ("Subject:LASI", "r_knee"); none of them twice."""
    by_key = {_key_of(label): landmark for label, landmark in marker_set.items()}
    exact = {marker_set[label] for label in labels if label in marker_set}
    found = []
    for label in labels:
        landmark = by_key.get(_key_of(label))
        is_free = landmark not in found and (landmark not in exact or label in marker_set)
        found.append(landmark if is_free else None)
    return found


def _key_of(label):
    """A label without what laboratories write differently: prefixes up to ":", case, and what separates words."""
    return re.sub(r"[\s._\-]+", "", label.rsplit(":", 1)[-1]).casefold()
