# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of Copy System Info, for reports of bugs. Nothing in it tells who the artist is, or names of the scene."""

import pathlib
import platform
import re
from collections import Counter

#: What stands for a name, and for a path or an address.
NAME, PATH = "...", "<path>"

_PATH = re.compile(r"[^\s'\"(]*[/\\][^\s'\")]*")
#: In quotes, as messages have names; an apostrophe within a word is none.
_QUOTED = re.compile(r"(?<!\w)'.*?'(?!\w)", re.DOTALL)


def text(sections):
    """Plain text of ((heading or "", ((label, value), ...)), ...); lines whose value is None or "" are left out."""
    blocks = []
    for heading, lines in sections:
        told = [f"{label}: {value}" for label, value in lines if value not in {None, ""}]
        blocks.append("\n".join([heading, *told] if heading else told))
    return "\n\n".join(block for block in blocks if block) + "\n"


def without_names(message, private):
    """`message` without paths, whatever stands in quotes, and the words `private` where they stand alone."""
    for word in sorted(filter(_is_telling, set(private)), key=len, reverse=True):
        message = re.sub(rf"(?<!\w){re.escape(word)}(?!\w)", NAME, message)
    return _PATH.sub(PATH, _QUOTED.sub(f"'{NAME}'", message))


def _is_telling(word):
    """Single letters and numbers stand in messages for other things."""
    return len(word) > 1 and not word.replace(".", "").isdigit()


def counted(kinds):
    """ "ARMATURE, SUBSURF 2" of an iterable of names, sorted; "none" of none."""
    counts = sorted(Counter(kinds).items())
    return ", ".join(kind if count == 1 else f"{kind} {count}" for kind, count in counts) or "none"


def processor(cpu_info="/proc/cpuinfo"):
    """The kind of processor, as the system calls it."""
    try:
        with pathlib.Path(cpu_info).open(encoding="utf-8") as lines:
            for line in lines:
                if line.startswith("model name"):
                    return " ".join(line.partition(":")[2].split())
    except OSError:  # other systems than Linux
        pass
    return platform.processor() or platform.machine()
