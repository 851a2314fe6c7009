# SPDX-License-Identifier: GPL-3.0-or-later
"""What the benchmarks share: timing, the machine's name, tables, and the JSON file."""

import argparse
import json
import platform
import statistics
import time
from datetime import date
from pathlib import Path


def median_seconds(action, repeats):
    """The median wall-clock time of `repeats` calls of action(), in seconds, and its last result."""
    seconds = []
    result = None
    for _ in range(repeats):
        start = time.perf_counter()
        result = action()
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds), result


def machine():
    """The processor's name and core count, for the head of a table."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.processor()}, {len(names)} cores"


def report(title, columns, rows, json_path):
    """Prints a table and writes it as JSON. columns: names; rows: lists of values in their order."""
    text = [[f"{value:.4g}" if isinstance(value, float) else str(value) for value in row] for row in rows]
    widths = [max(len(cell) for cell in column) for column in zip(columns, *text, strict=True)]
    print(f"{title} ({machine()}, {date.today().isoformat()})")
    for row in (columns, *text):
        print("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)))
    if json_path:
        content = {
            "title": title, "machine": machine(), "date": date.today().isoformat(), "columns": columns, "rows": rows
        }  # fmt: skip
        json_path.parent.mkdir(parents=True, exist_ok=True)
        json_path.write_text(json.dumps(content, indent=1) + "\n")


def json_argument(description):
    """The --json PATH argument of every benchmark, or None."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--json", type=Path)
    return parser.parse_args().json
