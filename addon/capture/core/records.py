# SPDX-License-Identifier: GPL-3.0-or-later
"""JSON as records, {name: cell} of a frame each, in any order of its parts and whatever is around them.

A name beside a score is that of the score; places of points are in "nose_x", "nose_y" and "nose_z".
"""

import collections
import functools
import json
import re

from ...errors import MotionFileError
from .marker_sets import NUMBERED
from .text_lines import REMEDY, decoded, number_in
from .time_columns import CLOCK, folded, number

#: Names, as folded() has them: of a name beside a score or a place, of that score, and of frames a second.
LABEL = re.compile("name|shape|label|key|^(k|(joint|marker|point|landmark)(id)?)$")
SCORES = {"score", "value", "weight", "values", "v"}
RATE, LARGEST_RATE = re.compile("fps|persecond|^(frame|sampl[a-z]+|recording|capture)?rate$"), 1000.0
#: Names of lists of points without names: of a body, of what else has points by number; those to be read first.
POINTS, PARTS, SOLID = map(re.compile, ("keypoint|landmark|joint|pose", "hand|face", "3d|world"))
MANY = re.compile("(keypoint|landmark|joint)(s|position|$)")  # of such a list of any length
#: Points that such a list has at least. Beyond so many pixels a third number up to 2 is how sure a point is.
FEWEST, COCO, PIXELS = 5, 17, 20.0
PERSONS = {"people", "persons", "instances"}  # the first counts


def of_json(data, file, refuse):
    """(records, frames a second that are told, or None) of bytes. refuse(reason, row, or None for the file) raises."""
    try:
        whole, rate_hz = loaded(decoded(data), file), None
        names, records = {}, collections.defaultdict(dict)
        for key, part in _heads(whole):
            if RATE.search(folded(key)) and 1.0 <= number(part) <= LARGEST_RATE:
                rate_hz = rate_hz or number(part)
            part = [*part.values()] if key.endswith("id2name") and isinstance(part, dict) else part  # of MMPose
            if isinstance(part, list) and part and all(isinstance(each, str) and each[:1].isalpha() for each in part):
                names[len(part)] = part
        _gather(whole, records, names, refuse)
        if not records:
            _gather([whole], records, names, refuse, row=0)  # one frame
    except (RecursionError, ValueError):  # also for an integer without end
        refuse("it is no list of frames")
    return [records[row] for row in range(max(records, default=-1) + 1)], rate_hz


def loaded(text, file):
    """What a JSON text has; a list where it has several, as an object a line. The last of them may be cut off."""
    found, decoder, between = [], json.JSONDecoder(), re.compile(r"[\s,]*")
    at = between.match(text).end()
    while at < len(text):
        try:
            part, at = decoder.raw_decode(text, at)
        except json.JSONDecodeError as error:
            if found and isinstance(found[-1], dict) and "\n" not in text[at:]:
                break
            raise MotionFileError(f"{file}, line {error.lineno}: {error.msg}. {REMEDY}") from None
        found.append(part)
        at = between.match(text, at).end()
    return found[0] if len(found) == 1 else found


def _heads(node, key=""):
    """(key, part) of a JSON value, of all in its objects and of the first in its lists."""
    yield key, node
    parts = {key: node[0]} if isinstance(node, list) and node else node if isinstance(node, dict) else {}
    for each, part in parts.items():
        yield from _heads(part, each)


def _gather(node, records, names, refuse, key="", row=None):
    """Puts all of a JSON value, whose outermost list has the rows, into `records`. names: {number: so many names}."""
    if isinstance(node, dict) and row is None and node and all(number_in(each) is not None for each in node):
        node = [{"": each, **part} for each, part in node.items() if isinstance(part, dict)]  # numbered frames
    single = dict if row is None else (dict, list)  # the only person
    if isinstance(node, list) and node:
        is_only = key in PERSONS or (len(node) == 1 and isinstance(node[0], single))
        is_only = is_only or (row is not None and are_persons(node))
        node = node[0] if is_only or node == names.get(len(node)) else node
    if row is None and isinstance(node, dict) and _is_frame(node, names):
        row = 0
    if isinstance(node, list) and row is not None:
        node = _named(node, key, names)
    if isinstance(node, list) and row is None:
        first = next((_kind(part) for part in node if part), None)
        for place, part in enumerate(node):
            if part and _kind(part) != first:
                refuse("it is not like the first one", place)
            _gather(part, records, names, refuse, key, place)
    elif isinstance(node, list):
        named = _kind(node) in names
        for name, part in zip(names[len(node)] if named else [key] * len(node), node, strict=True):
            if named or isinstance(part, (dict, list)):
                _gather(part, records, names, refuse, name, row)
    elif isinstance(node, dict):
        parts = plain(node, key)
        if parts is not node and any(isinstance(part, list) and _kind(part) not in names for part in parts.values()):
            row = None  # the list of a shape
        for name, part in sorted(parts.items(), key=lambda part: not SOLID.search(part[0])):
            _gather(part, records, names, refuse, name, row)
    elif row is not None:
        records[row].setdefault(key, node)


def are_persons(node):
    """Whether they are what is found in boxes of a picture, and say no more of which picture."""
    are_boxes = isinstance(node, list) and all(isinstance(each, dict) and "bbox" in each for each in node)
    return are_boxes and not any("image" in folded(key) or CLOCK.search(folded(key)) for each in node for key in each)


def _is_frame(node, names):
    """Whether an object has the points of one frame. Lists that are alike, but for one in space, are paths by name."""
    lists = [(folded(key), part) for key, part in node.items() if isinstance(part, list) and part]
    alike = collections.Counter((len(part), _kind(part[0])) for key, part in lists if not SOLID.search(key))
    return any(alike[len(part), _kind(part[0])] < 2 and _are_points(part, key, names) for key, part in lists)


def _are_points(node, key, names):
    """Whether it lists points of one frame: their numbers one after the other, lists of these, or places."""
    if _kind(node) == len(node):
        return "keypoint" in key
    are_places = all(_kind(part) in (2, 3, 4) or (_kind(part) is dict and {"x", "y"} <= part.keys()) for part in node)
    is_usual = POINTS.search(key) and len(node) in (COCO, *NUMBERED)
    return are_places and len(node) >= FEWEST and bool(len(node) in names or is_usual or MANY.search(key))


def _kind(node):
    """What the items of a list have in common: flat lists the number of what they have."""
    if isinstance(node, list):
        return list if any(isinstance(part, (dict, list)) for part in node) else len(node)
    return type(node) if isinstance(node, dict) else None


def _named(node, key, names):
    """{name, or number: {"x": ...}} of a list of points, also of their numbers one after the other, {"x": ...} of a
    place, {name: value} of the two; else the list."""
    label, points = folded(key), node
    if len(node) == 2 and isinstance(node[0], str):
        return {node[0]: node[1]}
    if len(node) == 3 and _kind(node) == 3 and key and 3 not in names and "color" not in label:
        return dict(zip("xyz", node, strict=True))
    if POINTS.search(label) and _kind(node) not in (list, *names):
        size = next((size for size in (3, 4, 2) if len(node) / size in (COCO, *names, *NUMBERED)), len(node) or 1)
        points = [node[at : at + size] for at in range(0, len(node), size)]
    points = [dict(zip("xyz", each, strict=False)) if isinstance(each, list) else each for each in points]
    if len(points) < FEWEST or not all(isinstance(each, dict) and {"x", "y"} <= each.keys() for each in points):
        return node
    depths = [number(each.get("z")) for each in points]
    is_flat = all(0.0 <= depth <= 2.0 for depth in depths) and max(number(each["x"]) for each in points) > PIXELS
    if "2d" in label or is_flat:
        points = [{"x": each["x"], "y": each["y"]} for each in points]
    called = names.get(len(points), map(str, range(len(points))))
    return {} if PARTS.search(label) else dict(zip(called, points, strict=True))


def plain(node, key=""):
    """An object; what is beside a name, a score or x and y, is by that name; of a place without one by `key`."""
    labels, score, axes, others = _roles(tuple(node))
    named = (node[each] for each in labels if isinstance(node[each], str)) if score or axes else ()
    label = next(filter(str.strip, named), key if axes else "")
    if not label:
        return node
    kept = (*others, *(each for each in labels if not isinstance(node[each], str)))
    mine = {f"{label}_{axis.lower()}": node[axis] for axis in axes} or {label: node[score]}
    return {each: node[each] for each in kept} | mine


@functools.lru_cache(4096)
def _roles(keys):
    """Of the keys of an object: ([those of names], that of a score or "", [of axes], [the others])."""
    axes = [key for key in keys if key in (*"xyzXYZ",)]
    axes = axes if len(axes) > 1 else []
    score = next((key for key in keys if folded(key) in SCORES), "")
    labels = [key for key in keys if LABEL.search(folded(key)) and key != score]
    return labels, score, axes, [key for key in keys if key not in (*labels, *axes, score) and folded(key) != "index"]
