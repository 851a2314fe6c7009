# SPDX-License-Identifier: MPL-2.0
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


def _processor_times():
    """(hundredths of seconds in which the machine worked or wanted to, those of them that its host gave to others)."""
    info = Path("/proc/stat")
    if not info.exists():
        return 0, 0
    user, nice, system, _idle, _wait, interrupts, soft_interrupts, stolen = map(
        int, info.read_text().split("\n", 1)[0].split()[1:9]
    )
    return user + nice + system + interrupts + soft_interrupts + stolen, stolen


_TIMES_BEFORE = _processor_times()


def stolen():
    """Of a virtual machine, for the head of a table: what its host kept from it since the benchmark began."""
    wanted, kept = (now - before for now, before in zip(_processor_times(), _TIMES_BEFORE, strict=True))
    share = kept / wanted if wanted > 0 else 0.0
    return f", {share:.0%} of its time taken by its host" if share >= 0.01 else ""


_TABLES = []
_MISSING = []


def missing(text):
    """Prints what can't be measured here, and keeps it for the JSON of the next report()."""
    print(f"missing: {text}")
    _MISSING.append(text)


def report(title, columns, rows, json_path):
    """Prints a table, and writes it as JSON with those that this benchmark reported before and what is missing.

    columns: names; rows: lists of values in their order.
    """
    text = [[f"{value:.4g}" if isinstance(value, float) else str(value) for value in row] for row in rows]
    widths = [max(len(cell) for cell in column) for column in zip(columns, *text, strict=True)]
    place, today = machine() + stolen(), date.today().isoformat()
    print(f"{title} ({place}, {today})")
    for row in (columns, *text):
        print("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)))
    if json_path:
        _TABLES.append({"title": title, "columns": columns, "rows": rows})
        content = {"machine": place, "date": today, "tables": _TABLES, "missing": _MISSING}
        json_path.parent.mkdir(parents=True, exist_ok=True)
        json_path.write_text(json.dumps(content, indent=1) + "\n")


def json_argument(description):
    """The --json PATH argument of every benchmark, or None."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--json", type=Path)
    return parser.parse_args().json
