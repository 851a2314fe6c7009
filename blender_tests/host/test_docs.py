# SPDX-License-Identifier: GPL-3.0-or-later
"""Links and pictures of the documentation lead somewhere, in the repository and in the site; its reference, lists and
examples are what the sources say."""

import importlib
import pathlib
import posixpath
import re
import sys
import unicodedata

import numpy as np
import pytest

from native.benchmarks import report_page

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = [*sorted(DOCS.rglob("*.md")), ROOT / "README.md", ROOT / "CHANGELOG.md", ROOT / "CONTRIBUTING.md"]
SITE = ROOT / "packaging" / "site" / "mkdocs.yml"
sys.path.insert(0, str(SITE.parent))


def prose(text):
    """Without code, in which brackets are no links."""
    text = re.sub(r"(?ms)^\s*```.*?^\s*```", "", text)
    return re.sub(r"`[^`\n]*`", "", text)


def links(text):
    """Targets of links and pictures."""
    return re.findall(r"\]\(([^()\s]+)\)", prose(text))


def anchors(text):
    """Those of the headings, the first of each name: the next ones get numbers, of another form in the site."""
    headings = re.findall(r"(?m)^#{1,6} (.*)$", re.sub(r"(?ms)^\s*```.*?^\s*```", "", text))
    return {slug(heading) for heading in headings}


def slug(heading):
    text = unicodedata.normalize("NFKD", re.sub(r"[`*]|\]\([^)]*\)|\[", "", heading))
    text = text.encode("ascii", "ignore").decode()
    return re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", text).strip().lower())


def problem(page, target):
    """What is wrong with a link on a page, or None."""
    if re.match(r"(https?|mailto):", target):
        return None
    path, _, anchor = target.partition("#")
    file = (page.parent / path).resolve() if path else page
    if not file.exists():
        return f"there is no {path}"
    if ROOT not in file.parents:
        return "it leaves the repository"
    if DOCS in page.parents and DOCS not in file.parents:
        return "it leaves docs/, and so the site"
    if DOCS in page.parents and file.is_dir():
        return "it is a folder: link a page"
    if anchor and anchor not in anchors(file.read_text("utf-8")):
        return f"{file.name} has no heading #{anchor}"
    return None


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    wrong = [f"{target}: {why}" for target in links(page.read_text("utf-8")) if (why := problem(page, target))]
    assert not wrong, "\n".join(wrong)


def test_every_page_is_in_the_menu_of_the_site():
    menu = SITE.read_text("utf-8").partition("\nnav:")[2]
    named = set(re.findall(r"[\w/]+\.md", menu))
    for name in named:
        assert (DOCS / name).is_file(), f"the menu has {name}"
    for page in DOCS.rglob("*.md"):
        name = page.relative_to(DOCS).as_posix()
        assert name in named or re.match(r"decisions/\d", name), f"{name} is in no menu: packaging/site/mkdocs.yml"


def test_every_picture_is_shown_somewhere():
    shown = {target for page in PAGES for target in links(page.read_text("utf-8")) if "pictures/" in target}
    assert {path.name for path in (DOCS / "pictures").iterdir()} == {pathlib.Path(target).name for target in shown}


def test_the_site_fetches_nothing_from_elsewhere():
    """Neither when it is built nor when it is read."""
    settings = re.sub(r"#.*", "", SITE.read_text("utf-8"))
    assert "font: false" in settings
    assert not re.search(r"https?://|extra_javascript|extra_css", settings)
    for page in DOCS.rglob("*.md"):
        assert not re.search(r"!\[[^]]*\]\(https?:|<(script|img|link|iframe)\b", prose(page.read_text("utf-8"))), page


def test_every_picture_has_what_makes_it():
    import guide_pictures

    made = {f"{name}.jpg" for name in guide_pictures.PICTURES} | set(guide_pictures.DEMOS) | guide_pictures.OTHERS
    assert made == {path.name for path in (DOCS / "pictures").iterdir()}


def test_the_manual_in_the_add_on_is_whole():
    import manual_page

    files = manual_page.files()
    assert {f"guide/{page.stem}.html" for page in (DOCS / "guide").glob("*.md")} < set(files)
    for name, content in files.items():
        if name.endswith(".html"):
            text = content.decode()
            for target in re.findall(r'(?:href|src)="([^"#]*)(?:#[^"]*)?"', text):
                assert not target or posixpath.normpath(posixpath.join(posixpath.dirname(name), target)) in files
            words = re.sub(r"<style>.*?</style>|<(code|pre)>.*?</\1>", "", text, flags=re.DOTALL)
            assert not re.search(r"\*|\]\(|`|^#|\|", words, re.MULTILINE), name


# -- what is written from the sources ----------------------------------------------------------------------------------


REFERENCE = DOCS / "reference"
WRITTEN = {name: REFERENCE / f"{name}.md" for name in ("python", "cpp")}
WRITTEN |= {"decisions": DOCS / "decisions" / "README.md", "jobs": REFERENCE / "jobs"}
ADVICE = "it is not what the sources say: ./dev docs reference writes it anew"


@pytest.mark.parametrize("name", WRITTEN)
def test_the_page_is_what_the_sources_say(name):
    module = importlib.import_module(f"{name}_page")
    said = {f"{job}.md": text for job, text in module.pages().items()} if name == "jobs" else {"": module.page()}
    assert said == {file: (WRITTEN[name] / file).read_text(encoding="utf-8") for file in said}, ADVICE


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


def test_the_first_example_poses_a_strip():
    (code,) = re.findall(r"(?ms)^```python\n(.*?)^```", (DOCS / "installing.md").read_text())
    names = {}
    exec(code, names)
    vertices, posed, anchors = names["vertices"], names["posed"], names["anchors"]
    assert np.array_equal(posed[anchors], names["targets"])
    free = np.setdiff1d(np.arange(len(vertices)), anchors)
    assert (posed[free, 2] > 0.0).any(), "nothing follows"

    def lengths(positions):
        """Of the edges along the strip, which the default method keeps."""
        return np.linalg.norm(positions[2:] - positions[:-2], axis=1)

    assert np.abs(lengths(posed) / lengths(vertices) - 1.0).max() < 0.25


def test_every_benchmark_has_its_place():
    scripts = pathlib.Path(report_page.__file__).parent.glob("bench_*.py")
    assert {path.stem.removeprefix("bench_") for path in scripts} == {section.name for section in report_page.SECTIONS}
