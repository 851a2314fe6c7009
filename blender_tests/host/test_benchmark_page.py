# SPDX-License-Identifier: GPL-3.0-or-later
"""./dev bench report: the page of what was measured."""

import json
import pathlib

from native.benchmarks import report_page

ROWS = [["body", "fast", 0.12345], ["bar", "a|b", 50412]]
TABLE = {"title": "T", "columns": ["shape", "method", "first s"], "rows": ROWS}


def written(folder, **benchmarks):
    """The page of benchmarks, each a machine's name."""
    for name, machine in benchmarks.items():
        content = {"machine": f"{machine}, 2 cores, 3% of its time taken by its host", "date": "2026-01-02"}
        content["missing"] = ["Open3D: not installed", "poses/samba.npz"]
        (folder / f"{name}.json").write_text(json.dumps({**content, "tables": [TABLE]}))
    (folder / "speed.png").write_bytes(b"plot")
    (folder / "pictures").mkdir()
    report_page.main(folder, folder / "page.md", folder / "pictures")
    return (folder / "page.md").read_text()


def test_tables_in_order_with_what_is_missing(tmp_path):
    page = written(tmp_path, bind="M", speed="M")
    assert "Run on M, 2 cores, 2026-01-02." in page
    assert page.index("`./dev bench speed`") < page.index("`./dev bench bind`")
    assert "| body | fast | 0.123 |" in page and "| bar | a\\|b | 50,412 |" in page
    assert "| body | 0.123 |" in page, "Binding again leaves out the method"
    assert "![Speed beside the peers: plots of the table below](pictures/speed.png)" in page
    assert (tmp_path / "pictures" / "speed.png").read_bytes() == b"plot"
    missing = page.splitlines()[-1]
    assert missing.startswith("Not in this run") and "`drag`" in missing and "`bind`" not in missing
    assert page.count("Missing: Open3D: not installed; poses/samba.npz.") == 2


def test_every_benchmark_has_its_place():
    scripts = pathlib.Path(report_page.__file__).parent.glob("bench_*.py")
    assert {path.stem.removeprefix("bench_") for path in scripts} == {section.name for section in report_page.SECTIONS}
