# SPDX-License-Identifier: GPL-3.0-or-later
"""Reader of OFF files: vertices and polygons. No bpy."""

import re
from pathlib import Path

import numpy as np

from .errors import DemoError

# OFF with optional normals, colours or texture coordinates; 4-D and n-D files have other columns.
HEADER = re.compile(r"^(ST)?C?N?OFF$")


def read_off(path):
    """Vertices (n, 3) float64 and a list of polygons (lists of vertex indices) of an OFF file.

    Columns after x y z and after a polygon's corners (normals, colours) are ignored.
    @throws DemoError naming the file and line.
    """
    lines = meaningful_lines(path)
    if not lines or not HEADER.match(lines[0][1][0].upper()):
        raise DemoError(f"{path} is not an OFF text file: its first word should be OFF")
    number, first = lines[0]
    lines = ([(number, first[1:])] if len(first) > 1 else []) + lines[1:]
    if not lines:
        raise DemoError(f"{path} ends after its header: vertex and face counts are missing")
    vertex_count, face_count = numbers(path, lines[0], int, 2)
    body = lines[1:]
    if len(body) < vertex_count + face_count:
        raise DemoError(
            f"{path} announces {vertex_count} vertices and {face_count} faces, "
            f"but has {len(body)} lines after its counts"
        )
    vertices = np.array([numbers(path, line, float, 3) for line in body[:vertex_count]]).reshape(-1, 3)
    faces = body[vertex_count : vertex_count + face_count]
    return vertices, [polygon(path, line, vertex_count) for line in faces]


def meaningful_lines(path):
    """(line number, words) of every line that is not blank or a comment."""
    try:
        with Path(path).open(encoding="utf-8", errors="replace") as file:
            split = [(number, line.split("#", 1)[0].split()) for number, line in enumerate(file, start=1)]
    except OSError as error:
        raise DemoError(f"{path} cannot be read: {error.strerror}") from error
    return [(number, words) for number, words in split if words]


def numbers(path, line, kind, count):
    """The first `count` words of a line as numbers."""
    number, words = line
    try:
        values = [kind(word) for word in words[:count]]
    except ValueError as error:
        raise DemoError(f"{path}, line {number}: {error}") from error
    if len(values) < count:
        raise DemoError(f"{path}, line {number}: {count} numbers are needed, there are {len(values)}")
    return values


def polygon(path, line, vertex_count):
    """The corner indices of a face line, checked."""
    (corner_count,) = numbers(path, line, int, 1)
    corners = numbers(path, (line[0], line[1][1:]), int, corner_count)
    if corner_count < 3 or min(corners) < 0 or max(corners) >= vertex_count:
        raise DemoError(
            f"{path}, line {line[0]}: a face needs three or more vertices between 0 and {vertex_count - 1}, "
            f"this one has {corners}"
        )
    return corners
