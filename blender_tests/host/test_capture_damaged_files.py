# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture/: damaged files end in a Take or in a MotionFileError, never in anything else.

MEANVALUE_CAPTURE_MUTATIONS raises the number of random mutations, docs/development.md.
"""

import os
import pathlib
import random
import signal
import sys
import tracemalloc

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from addon.core.capture import bvh_file, c3d_file, trc_file
from addon.errors import MotionFileError
from blender_tests.support import capture_files, walker
from blender_tests.support.mesh_files import DATA

READERS = {".c3d": c3d_file.read, ".trc": trc_file.read, ".bvh": bvh_file.read}
MUTATIONS = int(os.environ.get("MEANVALUE_CAPTURE_MUTATIONS", "1500"))
#: The memory for a file: so many times its size, and what an empty one takes.
MEMORY_FACTOR, MEMORY_AT_LEAST = 128, 2_000_000
#: Seconds after which a test is taken to hang; on a busy machine each takes a few.
HANGS_AFTER = 300

METRES = walker.positions(3)
MILLIMETRES = 1000.0 * walker.with_gaps(METRES, (1, 1, 2))
MOVES = ("Xposition", "Yposition", "Zposition", "Zrotation", "Yrotation", "Xrotation")
FIGURE = ("Hips", (0, 0, 0), MOVES, [("Head", (0, 60, 0), MOVES[3:], [(None, (0, 20, 0), (), [])])])


def small_files():
    """(name, content) of a file of each format: a few kilobytes."""
    outputs = {"ANGLES": ["HEAD"], "TYPE_GROUPS": ["ANGLES", "ANGLE"]}
    motion = np.round(np.random.default_rng(2).uniform(-90.0, 90.0, (3, 9)), 3)
    return [
        ("small.c3d", capture_files.c3d(walker.LABELS[:3], MILLIMETRES[:, :3], analog=2, point=outputs)),
        ("small.trc", capture_files.trc(walker.LABELS[:3], MILLIMETRES[:, :3], decimals=2)),
        ("small.bvh", capture_files.bvh(FIGURE, motion)),
    ]


def larger_files():
    """The same with more in it, in all number formats, and the real files where they are."""
    positions = 1000.0 * walker.with_gaps(walker.positions(40), (1, 3, 30), (4, 0, 5))
    groups = {"TRIAL": {"ACTUAL_START_FIELD": [1, 0], "ACTUAL_END_FIELD": [40, 0]}, "SUBJECTS": {"NAMES": ["A", "B"]}}
    files = [
        (
            f"{processor}{scale}.c3d",
            capture_files.c3d(walker.LABELS, positions, processor=processor, scale=scale, analog=8, groups=groups),
        )
        for processor in ("PC", "DEC", "SGI")
        for scale in (-0.1, 0.1)
    ]
    files.append(("walk.trc", capture_files.trc(walker.LABELS, positions)))
    files.append(("walk.bvh", capture_files.bvh(FIGURE, np.round(np.random.default_rng(4).normal(size=(40, 9)), 4))))
    real = [path for path in sorted((DATA / "mocap").glob("*/*")) if path.suffix.lower() in READERS]
    return files + [(path.name, path.read_bytes()) for path in real if path.stat().st_size < 100_000]


@pytest.fixture(autouse=True)
def ends_where_it_hangs():
    def give_up(*_):
        raise AssertionError(f"a file was read for more than {HANGS_AFTER} seconds")

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(HANGS_AFTER)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def attempt(name, content):
    """True if `content` gave a Take, which is then as Takes are; False if it was refused. Anything else fails."""
    try:
        take = READERS[pathlib.Path(name).suffix.lower()](content, name)
    except MotionFileError as error:
        assert str(error).startswith(name) and len(str(error)) < 500
        return False
    frames, markers, three = take.positions.shape
    assert frames > 0 and markers > 0 and three == 3 and take.positions.dtype == np.float64
    assert len(take.labels) == markers == len(set(take.labels)) and all(take.labels)
    assert np.isfinite(take.rate_hz) and take.rate_hz > 0.0
    missing = np.isnan(take.positions)
    assert np.array_equal(missing.any(axis=2), missing.all(axis=2)) and not missing.all()
    assert np.nanmax(np.abs(take.positions)) <= 1e4
    return True


@pytest.mark.parametrize("name, content", small_files(), ids=lambda value: value if isinstance(value, str) else "")
@pytest.mark.filterwarnings("error")
def test_every_byte_of_a_small_file_replaced(name, content):
    outcomes = []
    values = b"\0\x7f\xff" if name.endswith(".c3d") else b"\0\xff \n\t9-.{}e"
    for place in range(len(content)):
        for value in values:
            outcomes.append(attempt(name, content[:place] + bytes((value,)) + content[place + 1 :]))
    assert len(outcomes) > 1000 and any(outcomes) and not all(outcomes)


@pytest.mark.parametrize("name, content", small_files(), ids=lambda value: value if isinstance(value, str) else "")
@pytest.mark.filterwarnings("error")
def test_a_small_file_cut_off_at_every_length(name, content):
    outcomes = [attempt(name, content[:length]) for length in range(len(content))]
    first = outcomes.index(True)
    assert not any(outcomes[:100]) and all(outcomes[-2:]) and first < len(content) - 2


def mutated(content, random_numbers):
    """A copy with up to sixteen bytes or stretches replaced, dropped or doubled, mostly near the beginning; or cut."""
    result = bytearray(content)
    for _ in range(random_numbers.choice((1, 1, 2, 4, 16))):
        end = len(result) if random_numbers.random() < 0.3 else min(len(result), 3000)
        if end < 20:
            break
        place = random_numbers.randrange(end)
        act = random_numbers.random()
        if act < 0.7:
            result[place] = random_numbers.choice((0, 1, 2, 32, 48, 57, 127, 128, 255, random_numbers.randrange(256)))
        elif act < 0.8:
            del result[place : place + random_numbers.choice((1, 2, 7, 512))]
        elif act < 0.9:
            result[place:place] = result[place : place + random_numbers.choice((1, 2, 40, 512))]
        else:
            result[place : place + 4] = random_numbers.choice((b"\xff" * 4, b"\0" * 4, b"\x7f\x80\0\0", b"1e99"))
    return bytes(result[: random_numbers.randrange(len(result))] if random_numbers.random() < 0.1 else result)


@pytest.mark.filterwarnings("error")
def test_random_mutations():
    files = larger_files()
    random_numbers = random.Random(20)
    taken = 0
    for number in range(MUTATIONS):
        name, content = files[number % len(files)]
        damaged = mutated(content, random_numbers)
        try:
            taken += attempt(name, damaged)
        except Exception as error:
            raise AssertionError(f"mutation {number} of {name}") from error
    assert 0.1 * MUTATIONS < taken < 0.95 * MUTATIONS


def greedy_files():
    """Files that claim much more than they hold, or that hold little of much."""
    c3d = dict(small_files())["small.c3d"]

    def words(place, *values):
        return c3d[:place] + b"".join(value.to_bytes(2, "little") for value in values) + c3d[place + 2 * len(values) :]

    names = "".join(f"{k % 10}\t\t\t" for k in range(3000))
    trc_head = f"PathFileType\nNumMarkers\tUnits\n3000\tmm\nFrame#\tTime\t{names}\n\tX1\n"
    joints = "".join("JOINT a\n{\nOFFSET 0 1 0\n" for _ in range(3000)) + "}\n" * 3000
    leaves = "JOINT b\n{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n" * 1500
    heads = leaves.replace("b\n", "head\n").replace("0 1 0", "0 0 0") + "}\n" * 1500
    comb = leaves + "}\n" * 1500
    one_by_one = b"".join(b"\x02\x01" + k.to_bytes(2, "little") + b"\x04\0\x02\0" for k in range(15_000))
    root = "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n"
    return [
        ("points.c3d", words(2, 65535, 65535, 1, 65535)),
        ("frames.c3d", words(6, 0, 65535)),
        ("parameters.c3d", c3d[:514] + b"\xff" + c3d[515:516] + b"\x01\x01Z\x02\0" * 26_000),
        ("names.c3d", c3d[:514] + b"\xff" + c3d[515:516] + one_by_one + bytes(1000)),
        ("labels.trc", (trc_head + "1\t0\t1\n" * 3000).encode()),
        ("equal names.trc", (trc_head.replace("\t9\t", "\tA\t") + "1\t0" + "\t1\t2\t3" * 3000).encode()),
        ("middles.trc", (trc_head.replace("\t1\t", "\tMidA\t") + "1\t0" + "\t1\t2\t3" * 3000).encode()),
        ("a long name.trc", b"PathFileType\nUnits\nmm\nFrame#\tT\t" + b"a_" * 200_000 + b"\n\nX\n1\t0\t1\t2\t3\n"),
        ("newlines.trc", b"PathFileType\nUnits\nmm\nFrame#\tT\tA\n" + b"\n" * 300_000),
        ("joints.bvh", (root + joints + "}\nMOTION\nFrames: 3\nFrame Time: .01\n" + "0\n" * 3000).encode()),
        ("braces.bvh", b"HIERARCHY\nROOT r\n" + b"{" * 300_000),
        ("chain.bvh", (root + comb + "}\nMOTION\nFrames: 3\nFrame Time: .01\n" + "0 " * 1501).encode()),
        ("frames.bvh", (root + "}\nMOTION\nFrames: 999999999\nFrame Time: .01\n" + "0\n" * 100_000).encode()),
        ("heads.bvh", (root + heads + "}\nMOTION\nFrames: 1\nFrame Time: .01\n" + "0 " * 1501).encode()),
    ]


#: Of these, what claims what it does not hold, and cannot be read as anything smaller.
REFUSED = ("parameters.c3d", "labels.trc", "newlines.trc", "joints.bvh", "braces.bvh")


@pytest.mark.parametrize("name, content", greedy_files(), ids=lambda value: value if isinstance(value, str) else "")
def test_memory_stays_below_the_size_times_a_constant(name, content):
    assert attempt(name, content) == (name not in REFUSED)
    assert peak_memory(name, content) < MEMORY_FACTOR * len(content) + MEMORY_AT_LEAST


def test_memory_for_whole_and_mutated_files_too():
    random_numbers = random.Random(21)
    for name, content in larger_files() + small_files():
        for damaged in [content] + [mutated(content, random_numbers) for _ in range(4)]:
            assert peak_memory(name, damaged) < MEMORY_FACTOR * len(damaged) + MEMORY_AT_LEAST, name


def peak_memory(name, content):
    tracemalloc.start()
    try:
        attempt(name, content)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
