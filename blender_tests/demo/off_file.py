# SPDX-License-Identifier: GPL-3.0-or-later
"""Reader of OFF files: vertices and polygons. No bpy."""

import re
from pathlib import Path

import numpy as np

from . import DemoError

# OFF with optional normals, colours or texture coordinates; 4-D and n-D files have other columns.
HEADER = re.compile(r"^(ST)?C?N?OFF$")


def read_off(path):
    """Vertices (n, 3) float64 and a list of polygons (lists of vertex indices) of an OFF file.

    Columns after x y z and after a polygon's corners (normals, colours) are ignored.
    @throws DemoError.
    """
    try:
        text = Path(path).read_text(encoding="utf-8", errors="replace")
        lines = [words for words in (line.split("#", 1)[0].split() for line in text.splitlines()) if words]
        if not HEADER.match(lines[0][0].upper()):
            raise ValueError("its first word should be OFF")
        lines = [lines[0][1:], *lines[1:]] if len(lines[0]) > 1 else lines[1:]
        vertex_count, face_count = map(int, lines[0][:2])
        vertices = np.array([[float(word) for word in line[:3]] for line in lines[1 : 1 + vertex_count]]).reshape(-1, 3)
        faces = lines[1 + vertex_count : 1 + vertex_count + face_count]
        polygons = [[int(word) for word in line[1 : 1 + int(line[0])]] for line in faces]
    except (OSError, ValueError, IndexError) as error:
        raise DemoError(f"{path} cannot be read as an OFF file: {error}") from error
    corners = np.concatenate([np.array(polygon, int) for polygon in polygons]) if polygons else np.empty(0, int)
    if (len(vertices), len(polygons)) != (vertex_count, face_count) or min(map(len, polygons), default=3) < 3:
        raise DemoError(f"{path} announces {vertex_count} vertices and {face_count} faces that are not all there")
    if len(corners) and not 0 <= corners.min() <= corners.max() < vertex_count:
        raise DemoError(f"{path} has faces with vertices that are not there")
    return vertices, polygons
