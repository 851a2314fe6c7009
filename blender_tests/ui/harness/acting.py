# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a forgotten `yield from` a failure: without it, an act would silently not be done."""

import functools

forgotten = []


def act(function):
    """Decorator for a generator method. What it returns is only good for `yield from`."""

    @functools.wraps(function)
    def call(*arguments, **options):
        return _Act(function.__name__, function(*arguments, **options))

    return call


class _Act:
    def __init__(self, name, generator):
        self._name = name
        self._generator = generator
        self._begun = False

    def __iter__(self):
        self._begun = True
        return self._generator

    def __del__(self):
        if not self._begun:
            forgotten.append(self._name)
