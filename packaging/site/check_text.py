# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks the text of the pages: grammar and American spelling by Harper, and the rules of docs/style.md.

Argument: Harper's program. Words that it does not know are in words.txt beside this file. The texts of the interface
are checked as docs/reference/addon.md has them; other pages that scripts write, and formulas, are left out.
"""

import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
WORDS = pathlib.Path(__file__).with_name("words.txt")
LEFT_OUT = {DOCS / name for name in ("benchmarks.md", "algorithm.md", "reference/python.md", "reference/cpp.md")}
LEFT_OUT |= set((DOCS / "reference" / "jobs").glob("*.md"))
#: Read by artists: no sentence has more words.
GUIDE = ("README", "index", "installing", "troubleshooting", "how_it_works")
LONGEST = 30
#: Rules of Harper that are wrong about tables, code and the field's words, or a matter of taste.
NOT_OURS = (
    "SentenceCapitalization,UseTitleCase,OxfordComma,UseEllipsisCharacter,LongSentences,Spaces,SplitWords,MergeWords,"
    "ExpandMemoryShorthands,ExpandTimeShorthands,ExpandControl,ExpandMinimum,QuantifierNumeralConflict,WrongNegative,"
    "PhrasalVerbAsCompoundNoun,InflectedVerbAfterTo,PronounInflectionBe,MissingPreposition,Overall,Therein,Whereas,NotIn,"
    "DisjointPrefixes,ToTwoToo,NotTo,ThenThan,OrthographicConsistency,CompoundNouns,CapitalizePersonalPronouns"
)
#: Words of docs/style.md that no page needs.
AVOIDED = re.compile(r"\b(likewise|what is usual|in the morning|one version earlier)\b", re.IGNORECASE)


def pages():
    found = [*sorted(DOCS.rglob("*.md")), *(ROOT / f"{name}.md" for name in ("README", "CHANGELOG", "CONTRIBUTING"))]
    return [path for path in found if path not in LEFT_OUT]


def harper_lines(program):
    """What Harper finds, a line each."""
    command = [program, "lint", "--quiet", "--format", "json", "--dialect", "us", "--user-dict-path", WORDS]
    done = subprocess.run([*command, "--ignore", NOT_OURS, *pages()], capture_output=True, text=True)
    if not done.stdout:
        sys.exit(f"Harper failed: {done.stderr}")
    for page in json.loads(done.stdout):
        for found in page["lints"]:
            yield f"{page['file']}:{found['line']}: {found['rule']}: {found['matched_text']!r}: {found['message']}"


def sentences(text):
    """Sentences of a page, without code, links and pictures; a cell of a table, an item of a list ends one."""
    text = re.sub(r"(?ms)^\s*```.*?^\s*```", "", text)
    text = re.sub(r"!\[[^]]*\]\([^)]*\)|\]\([^)]*\)", " ", text)
    text = re.sub(r"(?m)^\s*(\*|\d+\.|#+) |^\s*$|\||<br>", "\n\n", text)
    for block in re.split(r"\n\s*\n", text):
        yield from re.split(r"(?<=[.!?:])[*\")\]]*\s+(?=[A-Z*`\"(\[])", " ".join(block.split()))


def own_lines():
    """What the rules of docs/style.md find."""
    for path in pages():
        text = path.read_text(encoding="utf-8")
        if path.name != "style.md":
            yield from (f"{path.name}: avoid {found.group()!r}" for found in AVOIDED.finditer(text))
        if path.stem in GUIDE or path.parent == DOCS / "guide":
            for sentence in sentences(text):
                count = len(re.findall(r"\S*\w\S*", sentence))
                if count > LONGEST:
                    yield f"{path.name}: a sentence of {count} words, at most {LONGEST}: {sentence[:80]}"


if __name__ == "__main__":
    lines = [*harper_lines(sys.argv[1]), *own_lines()]
    print("\n".join(lines))
    sys.exit(1 if lines else 0)
