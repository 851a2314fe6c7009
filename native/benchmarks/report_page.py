# SPDX-License-Identifier: MPL-2.0
"""Writes docs/benchmarks.md and its plots from what the benchmarks left as JSON.

Arguments: the folder with the JSON, the page, the folder of its pictures. A section tells what was missing in it, the
end of the page which benchmarks were. `--names` prints the benchmarks in the order of the page.
"""

import json
import pathlib
import shutil
import sys
import textwrap
from dataclasses import dataclass

HEAD = """# Benchmarks

Written by `./dev bench report` from `build/bench/*.json`; do not edit. Run on {machine}, {dates}.

*Diagonal* is that of the bounding box. Peers run in processes of their own on the same mesh with the same anchors. An
update of a peer is 10 iterations; ours runs until it has converged. What was tried is in the
[decisions](decisions/README.md).
"""


WIDTH = 120  # of lines of text


@dataclass(frozen=True)
class Section:
    """A benchmark's place on the page: its heading, a caption, and the columns that the page leaves out."""

    name: str
    heading: str
    caption: str
    without: frozenset = frozenset()


SECTIONS = (
    Section(
        "speed",
        "Speed beside the peers",
        "A compact *body* whose top turns by 120 degrees, and a thin *bar* that bends by 120 degrees. The first update "
        "is the jump; warm ones are the frames of a smooth path. *To converged*: distance to a solve at a tolerance of "
        "1e-10, *to a fresh solve*: to one from rest, of the worst vertex, in diagonals.",
    ),
    Section(
        "drag",
        "Dragging real models by few handles",
        "The whole mesh is free. *single*: nine single vertices are held; *patches*: six patches of 0.025 diagonals. "
        "One of them moves by 0.15 diagonals and turns by 40 degrees in 40 frames. The second table has the first and "
        "the last frame solved from rest; *energy/cold* and *apart* (the worst vertex, in diagonals) compare the end "
        "of the drag with that. Energies are over the squared diagonal.",
        frozenset({"iterations", "most", "converged", "missed", "frames", "first iterations", "last iterations"}),
    ),
    Section(
        "quality",
        "Quality beside the peers",
        "Poses whose true shape is known, by farthest-point anchors: means over the poses of a set. *rms* and *max* "
        "are in diagonals; *ratio* is rms over that of CGAL's spokes and rims. CGAL and libigl do 300 iterations, "
        "Open3D 100, Blender has Repeat 10.",
        frozenset({"seconds", "edge rms", "anchor miss"}),
    ),
    Section(
        "examples",
        "Examples (*Pose Like*)",
        "Poses left out in turn, all others of their set as examples: rms of all vertices in diagonals.",
    ),
    Section(
        "live",
        "Live posing in Blender",
        "From a moved control to a mesh that Blender has evaluated again, without drawing; medians of 30 frames.",
    ),
    Section(
        "follow",
        "A drag as a hand makes it",
        "60 steps a second, from rest. *Shown*: the mesh is where the control is when the next step comes, by an "
        "answer or a draft. *Off*: the largest rms distances from the settled shape in the first half second and in "
        "the next, in diagonals.",
    ),
    Section(
        "bind",
        "Binding again",
        "One handle of 100 vertices more on a bound mesh, beside a first bind.",
        frozenset({"method"}),
    ),
    Section(
        "bake",
        "Clips",
        "300 frames of a moving handle by `solve_sequence()`.",
        frozenset({"frames", "goal frames/s", "rounds"}),
    ),
    Section(
        "size",
        "By size",
        "A creature and a subdivided model, whole but for six patches or nine single vertices, dragged. *Draft*: what "
        "the add-on shows meanwhile, its rms distance from the answer, and how many of its triangles alone are turned "
        "over; *settle*: the last frame to the end of its valley. *Early*: from the beginning of a bind to the first "
        "shape by its coarsest level, and its distance from the settled one. In diagonals.",
        frozenset({"encode", "order", "hierarchy", "coarse level", "factor"}),
    ),
    Section(
        "morph",
        "Shapes between shapes",
        "The linear blend, Poisson's (Xu et al. 2005) and ours.",
    ),
    Section(
        "capture",
        "Markers",
        "A captured dancer of 9,971 vertices, 41 of them taken as markers, 24 frames; gaps of 10 % of the samples are "
        "left free or filled from the other markers.",
        frozenset({"goal", "strength"}),
    ),
    Section(
        "sliders",
        "Values of shape keys",
        "Random mixes of 8 shape keys of a face, found from markers by farthest points.",
        frozenset({"goal"}),
    ),
    Section(
        "wrap",
        "Wrap",
        "A body of 13,380 vertices in A-pose onto a man of 6,890 in T-pose. Percent of his diagonal; *pairs*: from a "
        "picked vertex to its place; *back*: from his vertices to the result.",
    ),
    Section(
        "keys",
        "Shape keys of another face",
        "The 56 keys of the ICT face on other triangles and in other shapes, in one call. Means over what moves, in "
        "percent of a key's largest move; *lids*: how far gaps of blinks are from the truth's, in percent of the "
        "eye's height; *turned over*: triangles that the truth does not turn. On identities plain offsets are true.",
    ),
    Section(
        "bones",
        "Bones of clips",
        "Clips as bones and at most four weights a vertex, on one thread; percent of the diagonal. *Plain*: one bone a "
        "vertex, by Lloyd's rounds alone.",
        frozenset({"goal"}),
    ),
    Section(
        "table1",
        "The paper's Table 1",
        "G is at diagonal 1. *[in print]* is on the paper's machine, a Pentium 4 at 3 GHz. Only ratios compare: the "
        "print does not say how G is normalized, which vertices are anchors, or how far they move, and our octopus and "
        "dolphin are other models. *Pyramid* is a reconstruction.",
        frozenset({"longest ring"}),
    ),
    Section(
        "encode",
        "Encoding",
        "One thread, medians of five. The error is that of putting vertices back.",
    ),
    Section(
        "full",
        "The full solver",
        "From rest to convergence. *To within 5%*: iterations until G is within 5 % of its last value.",
        frozenset({"stop"}),
    ),
    Section(
        "factor",
        "The sparse factorisation",
        "Matrices of generated grids (unknowns, or *x 3* for three a vertex) and of real meshes.",
    ),
    Section(
        "concurrency",
        "Several threads at once",
        "Binds, solves and cancels from some threads at once: *wrong* counts results with other bits than alone.",
    ),
)


def cell(value):
    """A number with three digits, a count with its thousands, or text."""
    if isinstance(value, float):
        return f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}"
    return str(value).replace("|", "\\|")


def table_lines(table, without):
    """A table in Markdown, under its title, without some columns."""
    kept = [number for number, name in enumerate(table["columns"]) if name not in without]
    lines = [f"*{table['title'].replace('*', ' ')}*", ""]
    names = [table["columns"][number].replace("|", "\\|") for number in kept]
    lines += ["| " + " | ".join(names) + " |", "|---" * len(kept) + "|"]
    lines += ["| " + " | ".join(cell(row[number]) for number in kept) + " |" for row in table["rows"]]
    return lines


def place(content):
    """The machine without what only one run saw of it."""
    return content["machine"].split(" cores")[0] + " cores"


def section_lines(section, content, first, picture, is_finished):
    lines = ["", f"## {section.heading}: `./dev bench {section.name}`", "", textwrap.fill(section.caption, WIDTH)]
    if place(content) != place(first):
        lines += ["", f"Run on {place(content)}."]
    if not is_finished:
        lines += ["", "*This benchmark failed; the tables have what it measured until then.*"]
    if picture:
        lines += ["", f"![{section.heading}: plots of the table below](pictures/{picture.name})"]
    for table in filter(lambda table: table["rows"], content["tables"]):
        lines += ["", *table_lines(table, section.without)]
    if content.get("missing"):
        lines += ["", textwrap.fill(f"Missing: {'; '.join(content['missing'])}.", WIDTH)]
    return lines


def main(folder, page, pictures):
    found = {path.stem: json.loads(path.read_text()) for path in folder.glob("*.json")}
    found = {section: found[section.name] for section in SECTIONS if section.name in found}
    if not found:
        sys.exit(f"there is no JSON of a benchmark in {folder}: run ./dev bench first")
    first = next(iter(found.values()))
    dates = sorted({content["date"] for content in found.values()})
    lines = HEAD.format(machine=place(first), dates=" to ".join(dict.fromkeys((dates[0], dates[-1])))).splitlines()
    for section, content in found.items():
        plot = folder / f"{section.name}.png"
        is_finished = not (folder / f"{section.name}.unfinished").exists()
        lines += section_lines(section, content, first, plot if plot.exists() else None, is_finished)
        if plot.exists():
            shutil.copyfile(plot, pictures / plot.name)
    missing = [f"`{section.name}`" for section in SECTIONS if section not in found]
    if missing:
        lines += ["", f"Not in this run, since they failed or lacked their data: {', '.join(missing)}."]
    page.write_text("\n".join(lines) + "\n")
    print(f"page: {page} of {len(found)} benchmarks")


if __name__ == "__main__":
    if sys.argv[1:] == ["--names"]:
        print(*(section.name for section in SECTIONS))
    else:
        main(*map(pathlib.Path, sys.argv[1:4]))
