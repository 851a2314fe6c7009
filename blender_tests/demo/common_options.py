# SPDX-License-Identifier: GPL-3.0-or-later
"""What the command lines of `./dev demo walk` and `./dev demo morph` have in common."""

import argparse
import os
from pathlib import Path


def parser(name, description, subjects, only):
    """An ArgumentParser of `./dev demo NAME`. subjects: names that --only takes; only: its help."""
    made = argparse.ArgumentParser(prog=f"./dev demo {name}", description=description, allow_abbrev=False)
    made.add_argument(
        "--output", metavar="FOLDER", type=Path, default=Path("build/demo"), help="default: %(default)s"
    )
    made.add_argument("--only", choices=tuple(subjects), help=only)
    made.add_argument(
        "--engine", choices=("cycles", "workbench"), default="cycles", help="workbench is quicker and plainer"
    )
    made.add_argument("--samples", metavar="N", type=int, default=16, help="Cycles samples per pixel; default: 16")
    return made


def parse(made, argv):
    """The words of `argv`, with the folder in full and the engine as Blender calls it."""
    words = made.parse_args(argv)
    if words.samples < 1:
        made.error(f"--samples {words.samples}: at least 1 is needed")
    words.output = (Path(os.environ.get("MEANVALUE_CALLED_FROM", ".")) / words.output).resolve()
    words.engine = {"cycles": "CYCLES", "workbench": "BLENDER_WORKBENCH"}[words.engine]
    return words
