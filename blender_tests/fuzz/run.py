# SPDX-License-Identifier: GPL-3.0-or-later
"""`./dev fuzz` of what reads files: one line for each kind, and exit code 1 where one is not as it should be."""

import argparse
import pathlib
import sys
import warnings

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from blender_tests.fuzz import driver


def main():
    parser = argparse.ArgumentParser(prog="./dev fuzz", description=__doc__)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"of: {', '.join(driver.NAMES)}; none: all")
    parser.add_argument("--runs", type=int, help="of each kind (10000 where --seconds is not given either)")
    parser.add_argument("--seconds", type=float, help="for each kind")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    unknown = sorted(set(options.kinds) - set(driver.NAMES))
    if unknown:
        parser.error(f"there is no kind {', '.join(unknown)}; there are {', '.join(driver.NAMES)}")
    runs = options.runs if options.runs or options.seconds else 10_000
    warnings.simplefilter("error")
    failed = False
    for name in options.kinds or driver.NAMES:
        try:
            run, taken = driver.fuzz(name, runs, options.seconds, options.seed)
            print(f"{name}: {run:,} files read, {taken:,} of them taken, seed {options.seed}", flush=True)
        except AssertionError as error:
            failed = True
            print(f"{name}: {error}", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
