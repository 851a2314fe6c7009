# SPDX-License-Identifier: GPL-3.0-or-later
"""./dev bench report: the page of what was measured."""

import pathlib

from native.benchmarks import report_page


def test_every_benchmark_has_its_place():
    scripts = pathlib.Path(report_page.__file__).parent.glob("bench_*.py")
    assert {path.stem.removeprefix("bench_") for path in scripts} == {section.name for section in report_page.SECTIONS}
