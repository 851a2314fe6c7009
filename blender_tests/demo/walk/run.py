# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo walk`, and its report."""

import time

from .. import pictures, report, row
from . import capture, measures, strip, subjects

ABOUT = (
    "motion capture",
    "The skinned figure is the generated one turned by its own bones with blended weights. Second differences are",
    "from sample to sample, 100 a second.",
)
DESCRIPTION = """\
Motion capture without a skeleton, from the file to the picture: a generated figure is moved by a generated C3D file
of 41 markers with gaps and noise. Import, match and bake by the add-on's operators, then film strips, the .blend and
a report."""
OPTIONS = {"subjects": subjects.GENERATED, "only": "just one of the three motions"}


def blocks(words, empty_scene):
    """The report's lines for each subject; makes the files."""
    return [one(make, words, empty_scene) for name, make in subjects.GENERATED.items() if words.only in (None, name)]


def one(make, words, empty_scene):
    """Makes, carries, measures and draws one subject; returns its lines of the report."""
    begin = time.perf_counter()
    empty_scene()
    subject = make(words.output)
    modelled = time.perf_counter()
    print(f"{subject.title}: importing, matching, baking ...", flush=True)
    carried = capture.carry(subject, words.output)
    seconds = {"model": modelled - begin, **carried.seconds}
    print(f"{subject.title}: rendering ...", flush=True)
    begin = time.perf_counter()
    path = draw(subject, carried, words, empty_scene)
    seconds["render"] = time.perf_counter() - begin
    rows = measures.rows(subject, carried)
    rows.append(("seconds", ", ".join(f"{stage} {value:.1f}" for stage, value in seconds.items())))
    rows.append(("files", f"{path.name}, {subject.stem}.blend"))
    return report.block(subject.title, rows)


def draw(subject, carried, words, empty_scene):
    """The strip from the side and from the front; its file."""
    views, path = [], words.output / f"{subject.stem}_strip.png"
    for azimuth in (strip.SIDE, strip.FRONT):
        empty_scene()
        strip.draw(path, subject, carried, subject.shown, azimuth, words.engine, words.samples)
        views.append(pictures.read_png(path))
    row.on_top(path, *views)
    return path
