# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws docs/pictures/house.svg: which part of the sources uses which, from their includes and imports.

A part stands above all that it uses. Lines that others imply are left out. Argument: the picture.
"""

import ast
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
NATIVE, ADDON = ROOT / "native", ROOT / "addon"
BOX, GAP, STEP, MARGIN, HEAD = (104, 34), 18, 74, 14, 30
COLORS = {"Solver: native/": "#4a7fb5", "Add-on: addon/": "#c46a3a"}


def included(path):
    """Names of folders of the solver that a file includes from."""
    return re.findall(r'(?m)^#include "(?:meanvalue/(?=\w+/))?(\w+)/', path.read_text())


def imported(path):
    """Names of rooms that a file of the add-on imports from."""
    package = path.relative_to(ADDON).parts[:-1]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            above = package[: len(package) - node.level + 1]
            base = [*above, *node.module.split(".")] if node.module else list(above)
            yield base[0] if base else ""


def uses(folders, suffixes, read):
    """{name: set of names} of folders, by what their files read from one another."""
    names = {folder.name for folder in folders}
    found = {}
    for folder in folders:
        files = [path for path in folder.rglob("*") if path.suffix in suffixes]
        found[folder.name] = {name for path in files for name in read(path)} & names - {folder.name}
    return found


def below(graph, name):
    """All that a part uses, through others too."""
    return graph[name].union(*(below(graph, other) for other in graph[name]))


def direct(graph):
    """Without what other lines imply."""
    return {
        name: {one for one in used if not any(one in below(graph, other) for other in used)}
        for name, used in graph.items()
    }


def levels(graph):
    """Rows of names from the bottom: each part above all that it uses, near the middle of these."""
    height = {}

    def of(name):
        if name not in height:
            height[name] = 1 + max((of(other) for other in graph[name]), default=-1)
        return height[name]

    rows = [[] for _ in range(1 + max(map(of, graph)))]
    for name in sorted(graph):
        rows[height[name]].append(name)
    for number, row in enumerate(rows[1:], 1):
        place = {name: (at + 0.5) / len(lower) for lower in rows[:number] for at, name in enumerate(lower)}
        row.sort(key=lambda name: sum(place[other] for other in graph[name]) / max(1, len(graph[name])))
    return rows


def panel(title, graph, left, height):
    """(SVG elements, width) of a title and its graph, whose lowest row is at `height`."""
    graph, (wide, high) = direct(graph), BOX
    rows = levels(graph)
    width = max(len(row) for row in rows) * (wide + GAP) - GAP
    place = {}
    for number, row in enumerate(rows):
        first = left + (width - len(row) * (wide + GAP) + GAP) / 2
        for at, name in enumerate(row):
            place[name] = (first + at * (wide + GAP), height - high - number * STEP)
    lines, boxes = [], []
    for name, (x, y) in place.items():
        for other in sorted(graph[name]):
            to_x, to_y = place[other]
            lines.append(
                f'<line x1="{x + wide / 2:g}" y1="{y + high:g}" x2="{to_x + wide / 2:g}" y2="{to_y:g}" stroke="#999"/>'
            )
        boxes.append(f'<rect x="{x:g}" y="{y:g}" width="{wide}" height="{high}" rx="5" fill="{COLORS[title]}"/>')
        boxes.append(f'<text x="{x + wide / 2:g}" y="{y + high / 2 + 5:g}" fill="#fff">{name}</text>')
    heading = f'<text x="{left + width / 2:g}" y="{HEAD - 8}" font-weight="bold" fill="#888">{title}</text>'
    return [heading, *lines, *boxes], width, len(rows)


def main(path):
    folders = [path for path in (NATIVE / "meanvalue").iterdir() if path.is_dir()]
    folders += [NATIVE / "reference", NATIVE / "bindings"]
    solver = uses(folders, (".h", ".cpp"), included)
    rooms = [path for path in ADDON.iterdir() if any(path.glob("**/*.py"))]
    addon = uses(rooms, (".py",), imported)
    tallest = max(len(levels(direct(graph))) for graph in (solver, addon))
    height, left, elements = HEAD + MARGIN + (tallest - 1) * STEP + BOX[1], MARGIN, []
    for title, graph in zip(COLORS, (solver, addon), strict=True):
        drawn, width, _ = panel(title, graph, left, height)
        elements += drawn
        left += width + 3 * MARGIN
    size = f'viewBox="0 0 {left - 2 * MARGIN:g} {height + MARGIN:g}"'
    style = 'font-family="sans-serif" font-size="14" text-anchor="middle" stroke-width="1.5"'
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {size} {style}>\n' + "\n".join(elements) + "\n</svg>\n")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
