# SPDX-License-Identifier: MPL-2.0
"""Binds, solves, cancels and numpy's products at once from 2 to 6 threads: how many gave other bits than alone."""

import argparse
import json
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from blender_tests.support import mesh_files, stress
from native.benchmarks import reporting

COLUMNS = ["meshes", "threads", "rounds", "binds and solves", "cancelled", "products", "seconds", "wrong"]
ROOT = pathlib.Path(__file__).resolve().parents[2]
THREADS = [2, 3, 4, 6]
MOST_TOLD = 5


def run(threads, rounds, seconds, model=None):
    """What stress.stress() returns, in a process of its own, or how that ended, as a string."""
    command = [sys.executable, stress.__file__, "--threads", str(threads), "--rounds", str(rounds)]
    command += ["--seconds", str(seconds)] + (["--model", str(model)] if model else [])
    try:
        # Cold runs alone come first, and a round that was begun is ended.
        ended = subprocess.run(command, capture_output=True, text=True, timeout=10 * seconds + 600, cwd=ROOT)
    except subprocess.TimeoutExpired:
        return "hangs"
    if ended.returncode != 0:
        return f"ends with {ended.returncode}: {ended.stderr.strip()[-200:]}"
    return json.loads(ended.stdout.splitlines()[-1])


def row(name, threads, report):
    if isinstance(report, str):
        return [name, threads, "", "", "", "", "", report]
    done = report["done"]
    solves = sum(done.get(action, 0) for action in ("bind_and_solve", "solve_kept", "tasks", "cancel_solve"))
    products = done.get("multiply", 0) + done.get("tasks", 0)
    return [
        name, threads, report["rounds"], solves, done.get("cancelled", 0), products, report["seconds"],
        len(report["wrong"]),
    ]  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=600, help="for each number of threads")
    parser.add_argument("--seconds", type=float, default=10.0, help="the most for each number of threads")
    arguments = parser.parse_args()
    model = next((path for path in mesh_files.model_paths() if path.name == "elephant.obj"), None)
    if model is None:
        reporting.missing("models/elephant.obj")
    rows, is_right = [], True
    for name, path in [("made", None), *([("elephant.obj", model)] if model else [])]:
        for threads in THREADS:
            report = run(threads, arguments.rounds, arguments.seconds, path)
            rows.append(row(name, threads, report))
            wrong = [report] if isinstance(report, str) else report["wrong"]
            is_right = is_right and not wrong
            for line in wrong[:MOST_TOLD]:
                print(f"{name}, {threads} threads: {line}")
            print(f"{name}, {threads} threads: {len(wrong)} wrong", flush=True)
    reporting.report("work of several threads at once, bit by bit", COLUMNS, rows, arguments.json)
    return 0 if is_right else 1


if __name__ == "__main__":
    sys.exit(main())
