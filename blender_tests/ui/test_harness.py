# SPDX-License-Identifier: GPL-3.0-or-later
"""How the harness judges what a Blender left behind."""

import json

import pytest
from harness import acting, process


@pytest.fixture
def judged(tmp_path, monkeypatch):
    """judged(events, output, end) gives the outcomes of the scenarios `first` and `second`."""
    monkeypatch.setattr(process, "OUTPUT", tmp_path)

    def judge(events, output, end=None):
        session = process._Session(tmp_path / "some_file.py", ["first", "second"])
        (tmp_path / "some_file.jsonl").write_text("".join(json.dumps(event) + "\n" for event in events))
        (tmp_path / "some_file.log").write_text(output)
        return {name: "\n".join(outcome.problems) for name, outcome in session._outcomes(end).items()}

    return judge


def ended(name):
    return {"end": name, "problems": [], "seconds": 1.0}


def test_traceback_belongs_to_its_scenario(judged):
    output = f"@@ first\n{process.TRACEBACK}:\n  KeyError: 3\n@@ second\nInfo: all is well\n"
    problems = judged([{"begin": "first"}, ended("first"), {"begin": "second"}, ended("second")], output)
    assert "KeyError: 3" in problems["first"]
    assert problems["second"] == ""


def test_crash_is_told_with_its_step_and_leaves_the_rest(judged):
    problems = judged([{"begin": "first"}, {"step": "key G"}], "@@ first\nWriting\n", "Blender crashed: SIGSEGV")
    assert list(problems) == ["first"]
    assert "SIGSEGV" in problems["first"] and "at the step: key G" in problems["first"]


def test_forgotten_act():
    @acting.act
    def press():
        yield

    list(press())
    assert acting.forgotten == []
    press()
    assert acting.forgotten == ["press"]
    acting.forgotten.clear()
