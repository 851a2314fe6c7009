# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a motion capture file of any known format."""

import functools
import json
import os
import pathlib
import re

from ...errors import MotionFileError
from . import bvh_file, c3d_file, records, table_file
from .recording import Take
from .text_lines import Lines, decoded

#: The suffixes of files that are known; what is in a file counts. All but these two are tables.
SUFFIXES = (".c3d", ".trc", ".bvh", ".csv", ".tsv", ".txt", ".json", ".jsonl")
_READERS = {".c3d": c3d_file.read, ".bvh": bvh_file.read}
_BEGINS = {r"\s*HIERARCHY": ".bvh", r"\s*PathFileType": ".trc", r"[\2-\x7f]P[^\0]{0,500}\0": ".c3d"}
_FOREIGN = {
    "Kaydara FBX|; ?FBX|glTF": "a scene, for Blender's own importers",
    "PK\3\4": "a workbook or an archive",
    r"\x93NUMPY|\x80[\2-\5]": "an archive of Python",
    r"\s*<(?!<)": "XML",
    r"(#.*\n\s*)*:(version|FULLY)": "an Acclaim skeleton or motion",
}


def read(path: str | os.PathLike, *, up_axis: str | None = None, unit: float | None = None, along=None) -> Take:
    """The markers in a motion capture file, as a Take: C3D, TRC, BVH, or points by name in CSV, TSV or JSON.

    Of numbered JSON files of a frame each, one stands for all; their paths go to the set `along`.
    `up_axis`: which of the file's axes points up, one of units.UP_AXES; None: as the file says. `unit`: meters for
    one unit of the file; None: as the file says. Where the file is silent, a plausible guess is made and told in the
    notes.
    Raises MotionFileError with the file's name, the reason and a remedy for whatever can't be read.
    """
    whole = functools.partial(_with_frames_beside, pathlib.Path(path), set() if along is None else along)
    return read_by(lambda data, *rest: parse(whole(data), *rest), SUFFIXES, path, up_axis, unit)


def _with_frames_beside(path, along, data):
    """The bytes of a take: `data`, or of one frame a JSON list of those in files called alike but for a number."""
    name = re.compile(r"(.*?)(\d+)(\D*\.json)", re.IGNORECASE | re.DOTALL)
    own = name.fullmatch(path.name)
    found = [(name.fullmatch(each.name), each) for each in path.parent.iterdir()] if own else []
    found = {its[2]: each for its, each in found if its and its.group(1, 3) == own.group(1, 3)}
    # Zeros fill up the number of digits, which large numbers go beyond: 07, 98, 100.
    filled = {len(number) for number in found if number != str(int(number)) and len(number) <= len(own[2])}
    digits = max(filled, default=1)
    frames = {int(number): each for number, each in found.items()
              if len(number) == digits or (len(number) > digits and number[0] != "0")}  # fmt: skip
    if len(frames) < 2:
        return data
    lines = Lines(data, path.name)
    count = len(records.of_json(data, path.name, lambda why, *_: lines.fail(why, number=1))[0])
    # Boxes may be of persons or of frames: of persons there are fewer than files.
    if count > 1 and not (count < len(frames) and records.are_persons(records.loaded(decoded(data), path.name))):
        return data
    along.update(frames.values())
    parts = [(at, records.loaded(decoded(each.read_bytes()), each.name)) for at, each in sorted(frames.items())]
    parts = [{**(part if isinstance(part, dict) else {"pose": part}), "frame": at} for at, part in parts]
    return json.dumps(parts).encode()


def parse(data, file, up_axis=None, unit=None):
    """As read(), of bytes: their beginning tells the format, else the suffix of the name `file`."""
    suffix = format_of(data) or pathlib.Path(file).suffix.lower()
    if suffix not in SUFFIXES and (not data.strip() or b"\0" in data[:4096]):
        raise MotionFileError(f"{file}: what ends in '{suffix}' is not read. Export it as one of {', '.join(SUFFIXES)}")
    return _READERS.get(suffix, table_file.read)(data, file, up_axis, unit)


def format_of(data):
    """The suffix of what begins as no other format does, else None."""
    return next((suffix for pattern, suffix in _BEGINS.items() if re.match(pattern, decoded(data[:4096]))), None)


def read_by(parse, suffixes, path, *options):
    """What parse(bytes, name, *options) makes of a file; suffixes: of files to choose. Raises as read()."""
    path, wanted = pathlib.Path(path), f"one of {', '.join(suffixes)}"
    try:
        if path.is_dir():
            raise MotionFileError(f"{path}: this is a folder. Choose a file in it: {wanted}")
        if not path.is_file():  # a pipe or a device would never end
            raise MotionFileError(f"{path}: there is no such file. Choose {wanted}")
        data = path.read_bytes()
        for pattern, what in _FOREIGN.items():
            if re.match(pattern, decoded(data[:4096])):
                raise MotionFileError(f"{path.name}: this is {what}, and is not read. Export it as {wanted}")
        return parse(data, path.name, *options)
    except OSError as error:
        raise MotionFileError(f"{path}: it cannot be opened ({error.strerror}). Check its permissions") from None
    except MemoryError:
        raise MotionFileError(f"{path}: the memory is too small for this file. Export a shorter range") from None
