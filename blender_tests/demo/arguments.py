# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo`. No bpy."""

import argparse
from dataclasses import dataclass
from pathlib import Path

from . import common_options
from .selection import SYNTAX, Selection, parse_selection

FORMATS = (".blend", ".glb", ".gltf", ".vrm", ".obj", ".ply", ".stl", ".off")
AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
# Upward direction in object space, and the rotation to +z: axis and degrees.
UP_AXES = {
    "X": ("Y", -90.0),
    "-X": ("Y", 90.0),
    "Y": ("X", 90.0),
    "-Y": ("X", -90.0),
    "Z": ("X", 0.0),
    "-Z": ("X", 180.0),
}

DESCRIPTION = """\
Poses meshes by their anchors with the Mean-Value Deform add-on, without a display, and leaves pictures
before and after, the .blend and a report.

Without FILE: an octopus that lifts a tentacle, and a textured game figure.
With FILE: your own mesh. Anchors hold the mesh; those that you move pull it along. Without any, Grab lifts what
reaches out farthest.
Motion capture has a demo of its own: ./dev demo walk --help"""

EXAMPLES = """\
examples:
  A game character, its hand lifted:
    ./dev demo character.vrm
  A .blend whose active shape key has the anchor groups "hand" and "hips" where they should go:
    ./dev demo figure.blend --anchor-group hand hips
  The same groups, moved from here; the group "arm" is what may move:
    ./dev demo figure.blend --anchor-group hand --roi-group arm --move hand 0 0 0.5 --rotate hand X 30
  A mesh without vertex groups:
    ./dev demo horse.off --anchor head=near:0.1,0.9,0.3,0.05 --hold legs=near:0,0,0,0.3 --move head 0 0.2 0
  A hand that swings upwards about a point of the arm; the arm and the shoulder may move:
    ./dev demo giant.obj --anchor hand=near:122,160,65,30 --roi near:90,185,24,88 --rotate Z 25 72,191,15

A selection of vertices is written """ + SYNTAX + """.
Coordinates, moves and rotation axes are the mesh's own (object space). A group turns first and moves then.
What bends keeps its length if the centre of the turn is halfway between the anchors that turn and those that hold."""


@dataclass(frozen=True)
class Anchor:
    """An anchor group: one of the file's vertex groups, or made from a selection."""

    name: str
    selection: Selection = None
    is_held: bool = False


@dataclass(frozen=True)
class Motion:
    """A step of one group to its target: turned about `centre` (None: about its centroid), then moved."""

    group: str
    offset: tuple = (0.0, 0.0, 0.0)
    axis: tuple = (0.0, 0.0, 1.0)
    angle_deg: float = 0.0
    centre: tuple = None


def build_parser():
    """The argparse parser, with nothing checked across options yet."""
    parser = argparse.ArgumentParser(
        prog="./dev demo",
        usage="./dev demo [FILE --anchor-group NAME ... | --anchor NAME=SELECTION ...] [--move ...] [options]",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("file", metavar="FILE", nargs="?", type=Path, help="a mesh: " + ", ".join(FORMATS))
    add_mesh_options(parser.add_argument_group("anchors and region (with FILE)"))
    add_pose_options(parser.add_argument_group("pose (with FILE)"))
    add_picture_options(parser.add_argument_group("pictures"))
    return parser


def add_mesh_options(group):
    """What holds and what may move."""
    several = {"nargs": "+", "action": "extend", "default": []}
    group.add_argument("--anchor-group", metavar="NAME", **several, help="vertex groups of the file that are anchors")
    group.add_argument(
        "--anchor",
        metavar="NAME=SELECTION",
        action="append",
        default=[],
        help="makes an anchor group from a selection",
    )
    group.add_argument("--hold", metavar="NAME[=SELECTION]", **several, help="anchor groups that stay where they are")
    group.add_argument(
        "--roi-group",
        "--roi",
        metavar="NAME|SELECTION",
        dest="roi",
        help="the vertices that may move: a vertex group or a selection; the whole mesh if left out",
    )
    group.add_argument("--object", metavar="NAME", help="which mesh object; default: active, only or, of glTF, largest")


def add_pose_options(group):
    """Where anchors go."""
    repeated = {"nargs": "+", "action": "append", "default": []}
    group.add_argument(
        "--move",
        metavar=("[NAME] X Y Z", ""),
        **repeated,
        help="moves an anchor group; NAME may be left out if only one is not held",
    )
    group.add_argument(
        "--rotate",
        metavar=("[NAME] AXIS DEGREES [X,Y,Z]", ""),
        **repeated,
        help="turns an anchor group about the point X,Y,Z, or else about its centroid; AXIS is X, Y, Z or like 0,1,1",
    )


def add_picture_options(group):
    """What the pictures look like and where they go."""
    common_options.add_options(group, ("octopus", "game_figure"), "without FILE: just one of the meshes", samples=32)
    group.add_argument(
        "--camera",
        metavar=("AZIMUTH", "ELEVATION"),
        nargs=2,
        type=float,
        help="degrees; 0 0 looks from the front (-y)",
    )
    group.add_argument(
        "--up",
        choices=tuple(UP_AXES),
        help="which way is up in FILE, as in --up=-Z; default: Y for .obj, as it is for .blend, else Z",
    )


def parse(argv):
    """The words of the command line, checked, with `anchors` and `motions`; no `file` asks for the built-in meshes.

    Leaves with a message and status 2 if they make no sense.
    """
    parser = build_parser()
    words = common_options.parse(parser, argv)
    if words.file is not None:
        words.file = common_options.typed(words.file)
    try:
        words.anchors = parse_anchors(words)
        words.motions = [parse_rotation(rotation, words.anchors) for rotation in words.rotate]
        words.motions += [parse_move(move, words.anchors) for move in words.move]
        check_file(words)
    except ValueError as error:
        parser.error(str(error))
    return words


def check_file(words):
    """@throws ValueError when FILE and the other options do not fit together."""
    if words.file is None:
        if words.anchors or words.motions or words.roi or words.object or words.up:
            raise ValueError(
                "anchors, region and pose need a FILE, before the other options; "
                "without one the built-in meshes are posed"
            )
        return
    if words.only:
        raise ValueError("--only is for the built-in meshes, without FILE")
    if words.file.suffix.lower() not in FORMATS:
        raise ValueError(f"{words.file}: the format must be one of {', '.join(FORMATS)}")
    if not words.file.is_file():
        raise ValueError(f"{words.file}: there is no such file")
    if words.file.resolve() == (words.output / words.file.name).resolve():
        raise ValueError(f"{words.file} would be overwritten; name another folder by --output")


def parse_anchors(words):
    """All anchor groups in the order given. @throws ValueError."""
    anchors = [Anchor(name) for name in words.anchor_group]
    anchors += [named_selection(text, is_held=False) for text in words.anchor]
    anchors += [named_selection(text, True) if "=" in text else Anchor(text, is_held=True) for text in words.hold]
    names = [anchor.name for anchor in anchors]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"anchor group '{twice[0]}' is named twice")
    return anchors


def named_selection(text, is_held):
    """An Anchor from NAME=SELECTION. @throws ValueError."""
    name, equals, selection = text.partition("=")
    if not (name and equals):
        raise ValueError(f"'{text}': write NAME=SELECTION, where the selection is {SYNTAX}")
    return Anchor(name, parse_selection(selection), is_held)


def parse_move(words, anchors):
    """A Motion from [NAME] X Y Z. @throws ValueError."""
    group, offset = split_motion("--move", words, 3, anchors)
    return Motion(group, offset=tuple(number("--move", word) for word in offset))


def parse_rotation(words, anchors):
    """A Motion from [NAME] AXIS DEGREES [X,Y,Z]. @throws ValueError."""
    centre = None
    if len(words) > 2 and "," in words[-1]:
        centre = triple("--rotate", "centre", words[-1])
        words = words[:-1]
    group, (axis, degrees) = split_motion("--rotate", words, 2, anchors)
    vector = AXES.get(axis.upper()) or triple("--rotate", "axis", axis)
    if not any(vector):
        raise ValueError(f"--rotate: the axis '{axis}' has no direction")
    return Motion(group, axis=vector, angle_deg=number("--rotate", degrees), centre=centre)


def split_motion(option, words, value_count, anchors):
    """(group name, values). @throws ValueError."""
    movable = [anchor.name for anchor in anchors if not anchor.is_held]
    if len(words) == value_count and len(movable) == 1:
        return movable[0], words
    if len(words) != value_count + 1:
        raise ValueError(
            f"{option} {' '.join(words)}: give the group's name and {value_count} values "
            "(the name may be left out if there is one anchor group that is not held; "
            f"here: {', '.join(movable) or 'none'})"
        )
    if words[0] not in movable:
        raise ValueError(
            f"{option} {words[0]}: that is not one of the anchor groups that may be moved "
            f"({', '.join(movable) or 'none'})"
        )
    return words[0], words[1:]


def triple(option, what, word):
    """Three numbers from X,Y,Z. @throws ValueError that names the option."""
    names = "X, Y, Z or " if what == "axis" else ""
    try:
        values = tuple(float(part) for part in word.split(","))
    except ValueError:
        values = ()
    if len(values) != 3:
        raise ValueError(f"{option}: the {what} '{word}' should be {names}three numbers like 0,1,1")
    return values


def number(option, word):
    """@throws ValueError that names the option."""
    try:
        return float(word)
    except ValueError:
        raise ValueError(f"{option}: '{word}' is not a number") from None
