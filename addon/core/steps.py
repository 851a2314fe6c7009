# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that is written as a generator, which yields how far it is and returns its result."""


def result_of(steps):
    """Goes through a generator at once. Returns what it returns."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value
