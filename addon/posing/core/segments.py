# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bones of a rig move as one, told by their names and parents: half a limb may have several, and so has a trunk.
Lengths, radii and angles do not tell: a bone that only twists looks like one that bends."""

import functools
import re

#: Words of names that say nothing of where a bone is.
_EMPTY = {"def", "org", "mch", "twist", "roll", "stretch"}
_TWIST = re.compile("twist|roll", re.IGNORECASE)
_TRUNK = re.compile("root|spine|hips|pelvis|torso|trunk|chest|breast|bust|belly|abdomen|stomach|waist|.*back$")
_LIMB = re.compile("shoulder|clavicle|collar|.*arm$|thigh|.*leg$")
_HEAD = re.compile("head|skull|face")
_ON_ITS_OWN = re.compile("hair|ears?$|.*tail|tongue|mane")  # of what is on a head
_OF_PARENT = re.compile("metacarpal|carpal|palm|heel")
_HALF = re.compile("up|low|fore|thigh|shin|shank|calf|neck")  # several bones with one of these, numbered, are one
_UPPER = re.compile("thigh|hip$|.*leg$|.*arm$|shoulder$")  # the upper half of a limb, where it is no lower one
_LOWER = re.compile("low|fore(?!foot)|shin|shank|calf|knee|elbow")


def of(parents):
    """{bone: a name for its segment, one for all that move as one}. parents: {bone: its parent or ""} of all bones."""
    return _of(tuple(parents.items()))


@functools.lru_cache(maxsize=4)
def _of(pairs):
    parents = dict(pairs)
    words = {bone: _words(bone) for bone in parents}
    above = {bone: above_of(bone, parents) for bone in parents}
    bears = {each for bone in parents if _has(words[bone], _LIMB) for each in above[bone]}
    spines = {bone for bone in parents if "spine" in words[bone]}
    # A spine that goes on beyond the shoulders is neck and head, where none above it is called so.
    topped = {each for bone in parents if _has(words[bone], "neck", "head") for each in above[bone]}
    beyond = {bone for bone in spines - bears - topped if not bears.isdisjoint(above[bone])}
    known = {words[bone] for bone in parents if not _TWIST.search(bone)}
    found = {}
    for bone in sorted(parents, key=lambda each: len(above[each])):
        own, parent = words[bone], found.get(next(iter(above[bone]), ""), "")
        is_last = not any(bone in above[each] for each in spines)
        if (parent == "head" and not _has(own, _ON_ITS_OWN)) or _has(own, _HEAD) or (bone in beyond and is_last):
            found[bone] = "head"
        elif bone in beyond:
            found[bone] = "neck"
        elif bears and not _has(own, _LIMB) and (bone in bears or _has(own, _TRUNK)):
            found[bone] = "trunk"
        elif parent and (_has(own, _OF_PARENT) or (_TWIST.search(bone) and own not in known)):
            found[bone] = parent
        else:
            is_one = _has(own, _HALF) or _TWIST.search(bone) or not re.search("[0-9]", bone)
            found[bone] = " ".join(own) if own and is_one else bone
    return found


def _words(name):
    parts = re.findall("[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name.rsplit(":", 1)[-1])
    return tuple(part.lower() for part in parts if part.lower() not in _EMPTY)


def _has(words, *kinds):
    return any(re.match(kind, word) for kind in kinds for word in words)


def above_of(bone, parents):
    """Its parents, the nearest first. Rigify's deforming bones hang on copies (ORG) of those that they stand for."""
    found = []
    while parents.get(bone):
        own, bone = bone, parents[bone]
        twin = bone.replace("ORG-", "DEF-", 1)
        if twin in parents and twin not in (own, *found):
            bone = twin
        found.append(bone)
    return found


def ways_up(parents, segment_of, segments):
    """Of each of `segments` the numbers of [itself, the one that it hangs on, the one that this hangs on, ...]."""
    tops, numbers = _tops(parents, segment_of), {name: number for number, name in enumerate(segments)}
    ways = ([name, *(segment_of[each] for each in above_of(tops[name], parents))] for name in segments)
    return [[numbers[each] for each in dict.fromkeys(way) if each in numbers] for way in ways]


def tops_up(bone, parents, bones):
    """First bones of the limb that `bone` is of, and of those that it hangs on: all that hang on others of `bones`."""
    way, segment_of = [bone, *above_of(bone, parents)] if bone else [], of(parents)
    found = {segment_of[each]: (each, number) for number, each in enumerate(way)}
    return [each for each, number in found.values() if not bones.isdisjoint(way[number + 1 :])]


def hinges(parents, segment_of):
    """[(first bone of the upper half, of the lower half, [first bones of what hangs on it])] of knees and elbows."""
    tops, found = _tops(parents, segment_of), []
    hung = {bone: next((segment_of[each] for each in above_of(bone, parents)), "") for bone in tops.values()}
    for name, bone in tops.items():
        upper = next(iter(above_of(bone, parents)), "")
        ends = [end for end, segment in hung.items() if segment == name]
        is_limb = _has(_words(upper), _UPPER) and not _is_lower(upper, parents)
        if ends and is_limb and _is_lower(bone, parents):
            found.append((tops[segment_of[upper]], bone, ends))
    return found


def _is_lower(bone, parents):
    """Of half a limb."""
    words, above = _words(bone), _words(next(iter(above_of(bone, parents)), ""))
    return _has(words, _LOWER) or (words[-1:] == ("leg",) and _has(above, "up", "thigh"))


def is_foot(bone):
    return _has(_words(bone), ".*foot$")


def is_arm(bone):
    """Of the lower half of a limb. Elbows point backward, knees forward."""
    return _has(_words(bone), ".*arm", "elbow", "fore")


def _tops(parents, segment_of):
    """{segment: its first bone}, parents first."""
    tops = {}
    for bone in sorted(parents, key=lambda each: len(above_of(each, parents))):
        tops.setdefault(segment_of[bone], bone)
    return tops
