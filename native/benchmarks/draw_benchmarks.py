# SPDX-License-Identifier: MPL-2.0
"""Draws what bench_speed and bench_quality left as JSON. Arguments: the folder with it, and `speed`, `quality` or both.

Writes speed.png and quality.png there.
"""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

SPEED_PANELS = ("bind s", "first update s", "warm median s", "peak MB")
TRUTH = "(true pose)"
DPI = 110


def draw_speed(content):
    """A row of panels for each shape: seconds and memory over the number of vertices, both logarithmic."""
    rows = [row for row in content["measured"] if "missing" not in row]
    shapes = list(dict.fromkeys(row["shape"] for row in rows))
    names = list(dict.fromkeys(row["method"] for row in content["measured"]))
    figure, axes = plt.subplots(
        len(shapes), len(SPEED_PANELS), figsize=(17, 4.2 * len(shapes)), squeeze=False, layout="constrained"
    )
    for line, shape in enumerate(shapes):
        for panel, column in zip(axes[line], SPEED_PANELS, strict=True):
            for number, name in enumerate(names):
                own = [row for row in rows if (row["shape"], row["method"]) == (shape, name)]
                series = [(row["vertices"], row[column]) for row in own if not isinstance(row[column], str)]
                if series:
                    panel.loglog(*zip(*series, strict=True), "o-", color=f"C{number}", label=name)
            panel.set(title=f"{shape}: {column}", xlabel="vertices")
            panel.grid(True, which="both", alpha=0.25)
        axes[line, 1].legend(fontsize=8)
    return titled(figure, content)


def draw_quality(content):
    """Bars: rms error, its ratio, dihedral error by set at the most anchors; and the bar's twist over its height."""
    most = max(row["anchors"] for row in content["means"])
    rows = [row for row in content["means"] if row["anchors"] == most and row["method"] != TRUTH]
    figure, axes = plt.subplots(2, 2, figsize=(15, 9), squeeze=False, layout="constrained")
    draw_bars(axes[0, 0], rows, "rms", f"rms error over the diagonal, {most} anchors")
    draw_bars(axes[0, 1], rows, "ratio", "the same, over that of CGAL's spokes and rims")
    draw_bars(axes[1, 0], rows, "dihedral deg", "rms error of the angles across edges, degrees")
    panel = axes[1, 1]
    for row in content["cases"]:
        if row["case"] == "bar" and "missing" not in row:
            panel.plot(row["heights"], np.array(row["turns"]) - row["turns"][0], label=row["method"])
    panel.set(title="bar twisted by 135 degrees: turn of each cross-section", xlabel="height", ylabel="degrees")
    panel.grid(True, alpha=0.25)
    if panel.lines:
        panel.legend(fontsize=8)
    return titled(figure, content)


def draw_bars(panel, rows, column, title):
    """Groups of bars, one group for each set."""
    sets = list(dict.fromkeys(row["set"] for row in rows))
    names = list(dict.fromkeys(row["method"] for row in rows))
    width = 0.8 / max(1, len(names))
    for number, name in enumerate(names):
        values = {row["set"]: row.get(column) for row in rows if row["method"] == name}
        heights = [values.get(name_of_set) or np.nan for name_of_set in sets]
        label = name if np.isfinite(heights).any() else f"{name}: missing"
        panel.bar(np.arange(len(sets)) + number * width, heights, width, label=label)
    panel.set(title=title, xticks=np.arange(len(sets)) + 0.4 - width / 2, xticklabels=sets)
    panel.grid(True, axis="y", alpha=0.25)
    panel.legend(fontsize=8)


def titled(figure, content):
    figure.suptitle(f"{content['machine']}, {content['date']}", fontsize=9)
    return figure


DRAWN = {"speed": draw_speed, "quality": draw_quality}

if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1])
    for benchmark in sys.argv[2:] or DRAWN:
        json_path = folder / f"{benchmark}.json"
        if not json_path.exists():
            print(f"nothing to draw: there is no {json_path.name}")
            continue
        DRAWN[benchmark](json.loads(json_path.read_text())).savefig(json_path.with_suffix(".png"), dpi=DPI)
        print(f"plot: {json_path.with_suffix('.png').name}")
