# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/reference/python.md and cpp.md, and the list of decisions, are what the sources say now."""

import importlib
import pathlib
import re
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
REFERENCE = ROOT / "docs" / "reference"
sys.path.insert(0, str(ROOT / "packaging" / "site"))

ADVICE = "it is not what the sources say: ./dev docs reference writes it anew"


PAGES = {name: REFERENCE / f"{name}.md" for name in ("python", "cpp")}
PAGES |= {"decisions": ROOT / "docs" / "decisions" / "README.md", "jobs": REFERENCE / "jobs"}


@pytest.mark.parametrize("name", PAGES)
def test_the_page_is_what_the_sources_say(name):
    module = importlib.import_module(f"{name}_page")
    said = {f"{job}.md": text for job, text in module.pages().items()} if name == "jobs" else {"": module.page()}
    assert said == {file: (PAGES[name] / file).read_text(encoding="utf-8") for file in said}, ADVICE


def test_python_page_has_every_function_with_text():
    import meanvalue

    page = (REFERENCE / "python.md").read_text()
    for name in vars(meanvalue):
        assert name.startswith("_") or name == "baselines" or re.search(rf"(?m)^### {name}\b", page), name
    for heading in re.findall(r"(?m)^#### (.*)$", page):
        text = page.partition(f"#### {heading}\n")[2]
        after = text.split("```")[2].strip()
        is_plain = f"```python\n{heading}\n```" in text  # a constructor without arguments
        assert is_plain or (after and not after.startswith("#")), f"{heading} has no docstring"


def test_cpp_page_has_no_private_member():
    page = (REFERENCE / "cpp.md").read_text()
    assert "private:" not in page
    for name in ("Deformer", "Morpher", "SliderFit", "Sequence", "Binding", "Execution", "InvalidInput", "share"):
        assert re.search(rf"(?m)^### {name}$", page), name
