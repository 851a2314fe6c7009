# SPDX-License-Identifier: GPL-3.0-or-later
"""Which points of a file are no markers on the subject: angles, forces and points that a model computed.

A C3D file tells by parameters of its group POINT: ANGLES, FORCES, ... hold labels of points that are no positions. All
else shows by the names alone.
"""

import re

#: Parameter of POINT that lists labels -> what they are.
KINDS = {name: name.lower() for name in ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS")}
KINDS |= dict.fromkeys(("MODELED_MARKERS", "MODELLED_MARKERS", "VIRTUAL_MARKERS"), "virtual points")
KINDS |= {"BONES": "segment axes"}
UNLABELLED = "unlabelled points"

#: Names of points that no marker can be: joint centers, center of mass, V_ for virtual (Motion Analysis), what is on
#: the ground below others or in the middle of two.
_VIRTUAL_NAME = re.compile(
    r"""(?: .*[:._\s] )?
        (?: cent(?:er|re)_?of_?mass(?:_?floor)? | com(?:_?floor)?
          | [lr]?[haksew]jc
          | .*joint[._\s]?cent(?:er|re) | .*(?:hip|knee|ankle|shoulder|elbow|wrist)[._\s]?joint(?:[._\s]?ground)?
          | (?:head|shoulder|hip|knee|ankle|heel|toe|mt5)[._\s]?ground
          | mid[._\s]?(?:asis|psis|clavicle|shoulders?|hips?|knees?|ankles?|pelvis)
          | v_.+ )""",
    re.IGNORECASE | re.VERBOSE,
)


def listed_in(parameters) -> dict[str, str]:
    """{label: kind} that a C3D file tells by its parameters."""
    kinds = dict(KINDS)
    types = parameters.strings("POINT", "TYPE_GROUPS")  # pairs: the parameter, and what one of it is called
    for name in types[0::2]:
        kinds.setdefault(name.upper(), name.lower())
    for name in ("LABELS", "DESCRIPTIONS", "UNITS", ""):
        kinds.pop(name, None)
    return {label: kind for name, kind in kinds.items() for label in parameters.all_strings("POINT", name)}


def kinds(labels: list[str], listed: dict[str, str] | None = None) -> list[str | None]:
    """For each label its kind, None for a marker. `listed`: {label: kind} that the file itself tells."""
    known = {**(listed or {}), **_segment_axes(labels), "": None}
    return [known.get(label) or _kind_by_name(label) for label in labels]


def _kind_by_name(label):
    if re.fullmatch(r"\*\d+", label):  # reflections that nobody gave to a marker are *1, *2, ... (Vicon)
        return UNLABELLED
    return "virtual points" if len(label) < 100 and _VIRTUAL_NAME.fullmatch(label) else None


def _segment_axes(labels):
    """{label: kind} of origin and ends of the three axes of body segments, as Plug-in Gait names them: PELO, PELA, PELL
    and PELP."""
    present = set(labels)
    stems = [label[:-1] for label in present if len(label) > 1 and {label[:-1] + end for end in "OALP"} <= present]
    return {stem + end: "segment axes" for stem in stems for end in "OALP"}
