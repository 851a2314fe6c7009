# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/decisions/README.md: the list of the decisions, by their headings.

python3 packaging/site/decisions_page.py FILE     writes the page
"""

import pathlib
import re
import sys

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "docs" / "decisions"
HEAD = """# Decisions

Choices that someone might want to undo, with what was weighed against them. A later one may replace an earlier one, and
says so. `./dev docs reference` writes this list.

| | |
|---|---|
"""


def page():
    rows = []
    for path in sorted(FOLDER.glob("0*.md")):
        number, title = re.match(r"# (\d+)\. (.*)", path.read_text(encoding="utf-8")).groups()
        rows.append(f"| {number} | [{title}]({path.name}) |\n")
    return HEAD + "".join(rows)


if __name__ == "__main__":
    pathlib.Path(sys.argv[1]).write_text(page())
