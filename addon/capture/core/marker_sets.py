# SPDX-License-Identifier: GPL-3.0-or-later
"""Which marker is where on the body: sets that laboratories use, recognised by their names, kept as JSON presets.

A set is {label: landmark}.
"""

import json
import re
from dataclasses import dataclass

from ...errors import InvalidMotionError
from . import landmarks as places
from .known_sets import BUILT_IN

FORMAT = "meanvalue marker set 1"


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


def recognise(labels, more_sets=None):
    """The `Recognition` of labels by the set, built in or of `more_sets` {name: set}, that knows most of them.

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
    for name, marker_set in {**(more_sets or {}), **BUILT_IN}.items():
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


def save(path, name, marker_set):
    """Writes a preset as JSON. Raises InvalidMotionError where that is impossible."""
    text = json.dumps({"format": FORMAT, "name": name, "landmarks": marker_set}, indent=1, ensure_ascii=False)
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise InvalidMotionError(f"The preset can't be written to {path}: {error.strerror}.") from error


def load(path):
    """(name, set) of a preset. Raises InvalidMotionError with file and reason for what is none."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        name, marker_set = content["name"], dict(content["landmarks"].items())
        is_known = all(places.segments_of(landmark) for landmark in marker_set.values())
        is_one = content["format"] == FORMAT and isinstance(name, str) and bool(marker_set) and is_known
    except OSError as error:
        raise InvalidMotionError(f"The preset {path} can't be read: {error.strerror}.") from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        is_one = False
    if not is_one:
        raise InvalidMotionError(f"{path.name} is no marker preset, or has unknown landmarks. Save it again.")
    return name, marker_set
