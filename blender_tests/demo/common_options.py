# SPDX-License-Identifier: GPL-3.0-or-later
"""What the command lines of all demos have in common."""

import argparse
import os
from pathlib import Path


def of_demo(name, description, argv, subjects=(), only="", engine="cycles", flags=()):
    """The words `argv` of `./dev demo NAME`. subjects: names that --only takes, if there are any; only: its help;
    flags: {what turns something on: its help}."""
    made = argparse.ArgumentParser(prog=f"./dev demo {name}", description=description, allow_abbrev=False)
    add_options(made, subjects, only, samples=16, engine=engine)
    for flag in flags:
        made.add_argument(flag, action="store_true", help=flags[flag])
    return parse(made, argv)


def add_options(made, subjects, only, samples, engine="cycles"):
    made.add_argument("--output", metavar="FOLDER", type=Path, default=Path("build/demo"), help="default: %(default)s")
    if subjects:
        made.add_argument("--only", choices=tuple(subjects), help=only)
    made.add_argument(
        "--engine",
        choices=("cycles", "workbench"),
        default=engine,
        help="workbench is quicker and plainer; default: %(default)s",
    )
    made.add_argument(
        "--samples", metavar="N", type=int, default=samples, help="Cycles samples per pixel; default: %(default)s"
    )


def parse(made, argv):
    """The words of `argv`, with the folder in full and the engine as Blender calls it."""
    words = made.parse_args(argv)
    if words.samples < 1:
        made.error(f"--samples {words.samples}: at least 1 is needed")
    words.output = typed(words.output)
    words.engine = {"cycles": "CYCLES", "workbench": "BLENDER_WORKBENCH"}[words.engine]
    return words


def typed(path):
    """In full: a path is meant from where the command was typed, which is not where Blender runs."""
    return (Path(os.environ.get("MEANVALUE_CALLED_FROM", ".")) / path).resolve()
