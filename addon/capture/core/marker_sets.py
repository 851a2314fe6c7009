# SPDX-License-Identifier: GPL-3.0-or-later
"""Which marker is where on the body: sets that laboratories use, recognised by their names, kept as JSON presets."""

import json
import re
from dataclasses import dataclass

from ...scene.core.checks import InvalidMotionError
from . import landmarks as places
from .known_sets import BUILT_IN
from .marker_set import MarkerSet

__all__ = ["MarkerSet", "Recognition", "load", "recognise", "save"]

FORMAT = "meanvalue marker set 1"


@dataclass(frozen=True)
class Recognition:
    """What `recognise()` found: the set that fits best and the landmark of each label that was asked for, or None."""

    name: str | None
    landmarks: tuple
    #: Labels that have a landmark, and labels of the set that nobody asked for.
    matched: int
    absent: tuple

    @property
    def words(self):
        """For the artist."""
        if self.name is None:
            return f"None of the {len(self.landmarks)} names is of a known marker set."
        rest = f"; {len(self.absent)} of that set are not there" if self.absent else ""
        return f"{self.name}: {self.matched} of {len(self.landmarks)} names known{rest}."


def recognise(labels, more_sets=()):
    """The `Recognition` of labels by the set, built in or of `more_sets`, that knows most of them.

    Of sets that know as many, the one with fewer absent markers. What all labels begin with, up to "_", is left out
    where that helps. Landmarks are not given twice: of two labels for one, the one that is written as the set has it
    is known, else the first.
    """
    labels = list(labels)
    prefix = re.match(r"(.+?_)", labels[0]) if len(labels) > 1 else None
    spellings = [labels]
    if prefix and all(label.startswith(prefix.group(1)) and label != prefix.group(1) for label in labels):
        spellings.append([label[len(prefix.group(1)) :] for label in labels])
    best, none = None, Recognition(None, (None,) * len(labels), 0, ())
    for marker_set in (*more_sets, *BUILT_IN):
        for spelling in spellings:
            found = _landmarks(marker_set, spelling)
            known = {landmark for landmark in found if landmark}
            absent = tuple(label for label, landmark in marker_set.landmarks.items() if landmark not in known)
            candidate = Recognition(marker_set.name, tuple(found), len(known), absent)
            if best is None or (candidate.matched, -len(absent)) > (best.matched, -len(best.absent)):
                best = candidate
    return best if best and best.matched else none


def _landmarks(marker_set, labels):
    """[landmark or None] of the labels, none of them twice."""
    exact = {marker_set.landmarks[label] for label in labels if label in marker_set.landmarks}
    found, taken = [], set()
    for label in labels:
        landmark = marker_set.landmark_of(label)
        is_free = landmark not in taken and (landmark not in exact or label in marker_set.landmarks)
        found.append(landmark if is_free else None)
        taken |= {found[-1]}
    return found


def save(path, marker_set):
    """Writes a preset as JSON. Raises InvalidMotionError where that is impossible."""
    text = json.dumps(
        {"format": FORMAT, "name": marker_set.name, "landmarks": marker_set.landmarks, "aliases": marker_set.aliases},
        indent=1,
        ensure_ascii=False,
    )
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise InvalidMotionError(f"The preset can't be written to {path}: {error.strerror}.") from error


def load(path):
    """The `MarkerSet` of a preset. Raises InvalidMotionError with file, reason and remedy for what is none."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InvalidMotionError(f"The preset {path} can't be read: {error.strerror}.") from error
    except (ValueError, RecursionError) as error:
        raise InvalidMotionError(f"{path.name} is no marker preset: it is not JSON ({error}).") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise InvalidMotionError(
            f"{path.name} is no marker preset: its \"format\" must be \"{FORMAT}\". Save the preset again."
        )
    name, landmarks, aliases = content.get("name"), content.get("landmarks"), content.get("aliases", {})
    if not isinstance(name, str) or not name.strip():
        raise InvalidMotionError(f"{path.name}: \"name\" must be the name of the marker set.")
    for key, table in (("landmarks", landmarks), ("aliases", aliases)):
        if not isinstance(table, dict) or not all(isinstance(value, str) for value in table.values()):
            raise InvalidMotionError(f"{path.name}: \"{key}\" must be a table of names.")
    if not landmarks:
        raise InvalidMotionError(f"{path.name}: \"landmarks\" is empty, a marker set needs at least one marker.")
    for label, landmark in landmarks.items():
        if not places.segments_of(landmark):
            known = ", ".join(sorted(places.PLACES))
            raise InvalidMotionError(
                f"{path.name}: '{landmark}' of marker '{label}' is no landmark. Known are {known}; .L or .R the side."
            )
    for alias, label in aliases.items():
        if label not in landmarks:
            raise InvalidMotionError(f"{path.name}: alias '{alias}' is of '{label}', which is no marker of the set.")
    return MarkerSet(name, landmarks, aliases)
