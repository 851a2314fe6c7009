# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers and names as messages show them."""

from . import line_breaks
from .language import translated


def counted(count, singular, plural=None):
    """`counted(1, "face")` is "1 face", `counted(1200, "vertex", "vertices")` is "1,200 vertices"."""
    word = singular if count == 1 else (plural or singular + "s")
    return f"{count:,} {word}"


def vertices(count):
    return translated("1 vertex") if count == 1 else translated("{count} vertices", count=f"{count:,}")


def seconds(value):
    """As many figures as it takes to see what is slow: "0.4 ms", "35 ms", "2.31 s", "140 s"."""
    if value < 0.001:
        return f"{value * 1000:.1g} ms"
    if value < 1.0:
        return f"{value * 1000:.0f} ms"
    return f"{value:.2f} s" if value < 100.0 else f"{value:.0f} s"


def share(value):
    """A part of something, from 0 to 1: "0%", "less than 0.1%", "4.2%"."""
    return "less than 0.1%" if 0.0 < value < 0.0005 else f"{value:.1%}" if value else "0%"


def duration(value):
    """What is left of a wait, no finer than anybody wants to know: "5 s", "3 min 20 s", "2 h 05 min"."""
    whole = max(1, round(value))
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


def listed(words):
    """"a", "a and b", "a, b and c"."""
    words = list(words)
    if len(words) < 2:
        return "".join(words)
    return ", ".join(words[:-1]) + " and " + words[-1]


def quoted(names, limit=3):
    """Names in quotes; after `limit` of them only how many more there are."""
    names = list(names)
    shown = [f"'{name}'" for name in names[:limit]]
    if len(names) > limit:
        shown.append(f"{len(names) - limit} more")
    return listed(shown)


def sentence(text):
    """First letter in upper case, the rest untouched, one full stop, as the script has it."""
    text = first_upper(text).rstrip(".。")
    return text + ("。" if line_breaks.is_wide(text[-1:]) else ".")


def first_upper(text):
    """First letter in upper case, the rest untouched."""
    return text[:1].upper() + text[1:]


def stage(name):
    """What the native solver calls one of its stages, for artists."""
    stages = {
        "": translated("starting"),
        "encode": translated("describing the shape"),
        "order": translated("preparing the solver"),
        "analyse": translated("preparing the solver"),
        "cells": translated("comparing the shapes"),
        "blend": translated("mixing the shapes"),
        "build hierarchy": translated("simplifying the mesh"),
        "coarse level": translated("preparing the simplified mesh"),
        "factor": translated("preparing the solver"),
        "solve": translated("finding the pose"),
    }
    return stages.get(name, name)
