# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo`. No bpy."""

import argparse
from pathlib import Path

from . import common_options

FORMATS = (".blend", ".glb", ".gltf", ".vrm", ".obj", ".ply", ".stl", ".off")
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
Poses meshes with the Mean-Value Deform add-on, without a display, and leaves pictures before and after, the .blend and
a report. Without FILE: an octopus that lifts a tentacle, and a textured game figure. With FILE: your own mesh, of which
Grab lifts what reaches out farthest. Motion capture has a demo of its own: ./dev demo walk --help"""


def parse(argv):
    """The words of the command line, checked; no `file` asks for the built-in meshes.

    Leaves with a message and status 2 if they make no sense.
    """
    parser = argparse.ArgumentParser(prog="./dev demo", description=DESCRIPTION, allow_abbrev=False)
    parser.add_argument("file", metavar="FILE", nargs="?", type=Path, help="a mesh: " + ", ".join(FORMATS))
    common_options.add_options(parser, ("octopus", "game_figure"), "without FILE: just one of the meshes", samples=32)
    parser.add_argument("--object", metavar="NAME", help="mesh; default: the active, the only, or a glTF's largest")
    parser.add_argument(
        "--up",
        choices=tuple(UP_AXES),
        help="which way is up in FILE, as in --up=-Z; default: Y for .obj, as it is for .blend, else Z",
    )
    words = common_options.parse(parser, argv)
    if words.file is not None:
        words.file = common_options.typed(words.file)
    try:
        check_file(words)
    except ValueError as error:
        parser.error(str(error))
    return words


def check_file(words):
    """@throws ValueError when FILE and the other options do not fit together."""
    if words.file is None:
        if words.object or words.up:
            raise ValueError("--object and --up need a FILE; without one the built-in meshes are posed")
        return
    if words.only:
        raise ValueError("--only is for the built-in meshes, without FILE")
    if words.file.suffix.lower() not in FORMATS:
        raise ValueError(f"{words.file}: the format must be one of {', '.join(FORMATS)}")
    if not words.file.is_file():
        raise ValueError(f"{words.file}: there is no such file")
    if words.file.resolve() == (words.output / words.file.name).resolve():
        raise ValueError(f"{words.file} would be overwritten; name another folder by --output")
