# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers and names as messages show them."""


def counted(count, singular, plural=None):
    """`counted(1, "face")` is "1 face", `counted(1200, "vertex", "vertices")` is "1,200 vertices"."""
    word = singular if count == 1 else (plural or singular + "s")
    return f"{count:,} {word}"


def vertices(count):
    return counted(count, "vertex", "vertices")


def share(value):
    """A part of something, from 0 to 1: "0%", "less than 0.1%", "4.2%"."""
    return "less than 0.1%" if 0.0 < value < 0.0005 else f"{value:.1%}" if value else "0%"


def frame(number):
    """ "12", "12.5"."""
    return f"{number:.3f}".rstrip("0").rstrip(".") if number % 1 else f"{number:.0f}"


def duration(value):
    """What is left of a wait, no finer than anybody wants to know: "5 s", "3 min"."""
    whole = max(1, round(value))
    return f"{whole} s" if whole < 60 else f"{whole // 60} min"


def listed(words):
    """ "a", "a and b", "a, b and c"."""
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
    """First letter in upper case, the rest untouched, one full stop."""
    return text[:1].upper() + text[1:].rstrip(".") + "."


def stage(name):
    """What the native solver calls one of its stages, for artists."""
    stages = {
        "": "starting",
        "encode": "describing the shape",
        "order": "preparing the solver",
        "analyse": "preparing the solver",
        "cells": "comparing the shapes",
        "blend": "mixing the shapes",
        "build hierarchy": "simplifying the mesh",
        "coarse level": "preparing the simplified mesh",
        "factor": "preparing the solver",
        "solve": "finding the pose",
    }
    return stages.get(name, name)
