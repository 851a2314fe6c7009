# SPDX-License-Identifier: GPL-3.0-or-later
"""Damaged files of every kind end in an error by name, or are read: the short lane of `./dev fuzz`, and every byte of
small captures."""

import pytest

pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.fuzz import driver
from blender_tests.fuzz.motion_files import attempt, small_files

RUNS = 300
#: Refused by their checksum, whatever is damaged. Few damaged files are none. (Chunks have bytes that say nothing.)
CHECKED = ("bundle",)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", driver.NAMES)
def test_damaged_files(name):
    run, taken = driver.fuzz(name, RUNS)
    assert run == RUNS and taken < RUNS
    assert taken < 0.05 * RUNS if name in CHECKED else taken > 0.02 * RUNS


# -- captures: a Take or a MotionFileError, never anything else --------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name, content", small_files(), ids=lambda value: value if isinstance(value, str) else "")
@pytest.mark.filterwarnings("error")
def test_every_byte_of_a_small_file_replaced(name, content):
    outcomes = []
    values = b"\0\x7f\xff" if name.endswith(".c3d") else b"\0\xff \n\t9-.{}e"
    for place in range(len(content)):
        for value in values:
            outcomes.append(attempt(name, content[:place] + bytes((value,)) + content[place + 1 :]))
    assert len(outcomes) > 1000 and any(outcomes) and not all(outcomes)


@pytest.mark.slow
@pytest.mark.parametrize("name, content", small_files(), ids=lambda value: value if isinstance(value, str) else "")
@pytest.mark.filterwarnings("error")
def test_a_small_file_cut_off_at_every_length(name, content):
    outcomes = [attempt(name, content[:length]) for length in range(len(content))]
    first = outcomes.index(True)
    assert not any(outcomes[:100]) and all(outcomes[-2:]) and first < len(content) - 2


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


@pytest.mark.slow
@pytest.mark.parametrize("name, content", greedy_files(), ids=lambda value: value if isinstance(value, str) else "")
def test_memory_stays_below_the_size_times_a_constant(name, content):
    kind = driver.MotionFiles(name.rpartition(".")[2])
    assert driver.attempt_within_memory(kind, content, None) == (name not in REFUSED)
