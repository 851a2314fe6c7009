# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads damaged files, one after another, and looks at what comes of each."""

import contextlib
import functools
import os
import pathlib
import random
import signal
import tempfile
import time
import tracemalloc

from . import cache_files, motion_files
from .mutations import mutated

#: Seconds after which a file is taken to hang its reader.
HANGS_AFTER = 10
#: The memory for a file: so many times its size, and what an empty one takes.
MEMORY_FACTOR, MEMORY_AT_LEAST = 128, 2_000_000
#: Lists of frames are as long as they say, up to MOST_FRAMES of meanvalue_farm.py.
MEMORY_OF_FRAMES = 250_000_000
#: A disk in memory, where there is one: opening a file to write it anew takes longer than reading it otherwise.
MEMORY_DISK = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
#: The memory of every so many-th file is looked at, which makes reading it slow.
MEMORY_EVERY = 100


class MotionFiles:
    """Of one format."""

    damaged = staticmethod(mutated)

    def __init__(self, suffix):
        self.name = suffix
        files = motion_files.small_files() + motion_files.larger_files()
        self.seeds = [content for name, content in files if name.endswith(suffix) and len(content) < 20_000]

    def attempt(self, content, _folder):
        return motion_files.attempt(f"fuzz.{self.name}", content)


MOTION = ("c3d", "trc", "bvh")
NAMES = (*MOTION, *(kind.name for kind in cache_files.KINDS))


def kind_of(name, folder):
    if name in MOTION:
        return MotionFiles(name)
    return next(kind for kind in cache_files.KINDS if kind.name == name)(folder)


def fuzz(name, runs=None, seconds=None, seed=0):
    """(files read, files taken). Ends after so many runs or seconds. @throws AssertionError that tells the run."""
    folder = functools.partial(tempfile.TemporaryDirectory, dir=MEMORY_DISK)
    with folder() as made, folder() as read:
        kind = kind_of(name, pathlib.Path(made))
        until = time.monotonic() + seconds if seconds is not None else float("inf")
        run = taken = 0
        while (runs is None or run < runs) and time.monotonic() < until:
            random_numbers = random.Random(f"{name} {seed} {run}")
            content = kind.damaged(random_numbers.choice(kind.seeds), random_numbers)
            try:
                with hanging_told():
                    look = attempt_within_memory if run % MEMORY_EVERY == 0 else type(kind).attempt
                    taken += look(kind, content, pathlib.Path(read))
            except Exception as error:
                raise AssertionError(f"run {run} of {name}, seed {seed}: {error!r} for {content[:2000]!r}") from error
            run += 1
    return run, taken


def attempt_within_memory(kind, content, folder):
    tracemalloc.start()
    try:
        taken = kind.attempt(content, folder)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    most = MEMORY_FACTOR * len(content) + (MEMORY_OF_FRAMES if kind.name == "frames" else MEMORY_AT_LEAST)
    assert peak < most, f"{peak:,} bytes of memory for a file of {len(content):,}"
    return taken


@contextlib.contextmanager
def hanging_told():
    if not hasattr(signal, "setitimer"):  # Windows has no such timer: a reader that hangs is seen by whoever waits
        yield
        return

    def give_up(*_):
        raise TimeoutError(f"it was read for more than {HANGS_AFTER} seconds")

    before = signal.signal(signal.SIGVTALRM, give_up)
    signal.setitimer(signal.ITIMER_VIRTUAL, HANGS_AFTER)  # of this process alone: the machine may be busy
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)
