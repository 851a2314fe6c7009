# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches, what is begun of them, and chunks of farms: whole files or none, whatever happens.
Which frames are kept."""

import errno
import os
import pathlib
import random
import struct
import subprocess
import sys
import time

import numpy as np
import pytest
from fuzz.cache_files import FARM

from addon.baking.core import bake_times, point_cache
from addon.errors import CacheError, DamagedCacheError, SceneError
from addon.scene.core import whole_files
from addon.solver.job import result_of

ROOT = pathlib.Path(__file__).resolve().parents[2]


def shapes(frames, vertices=7, seed=0):
    return np.random.default_rng(seed).standard_normal((frames, vertices, 3)).astype(np.float32)


def header(rows, start=1.0, rate=1.0):
    return point_cache.Header(rows.shape[1], start, rate, len(rows))


def write(path, rows, start=1.0, rate=1.0):
    with whole_files.replacing(path) as file:
        file.write(header(rows, start, rate).packed() + rows.tobytes())


def left_behind(folder):
    return [path.name for path in pathlib.Path(folder).rglob("*.tmp.*")]


# -- the format ------------------------------------------------------------------------------------------------------


def test_the_bytes_are_those_of_the_format_and_are_read(tmp_path):
    rows, path = shapes(3), tmp_path / "deep" / "a.pc2"
    write(path, rows, -2.5, 0.5)
    content = path.read_bytes()
    assert content[:12] == b"POINTCACHE2\0"
    assert struct.unpack("<iiffi", content[12:32]) == (1, 7, -2.5, 0.5, 3)
    assert content[32:] == rows.astype("<f4").tobytes()
    assert point_cache.read_header(path) == header(rows, -2.5, 0.5)
    assert np.array_equal(point_cache.mapped(path), rows)
    assert left_behind(tmp_path) == []


@pytest.mark.parametrize("length", [0, 5, 31, 32, 100])
def test_truncated_files_are_told(tmp_path, length):
    rows = shapes(3)
    path = tmp_path / "a.pc2"
    write(path, rows)
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(DamagedCacheError, match=r"a\.pc2"):
        point_cache.read_header(path)


def test_headers_that_lie_are_told(tmp_path):
    path = tmp_path / "a.pc2"
    for vertices, samples in ((-1, -84), (2**31 - 1, 2**31 - 1), (7, -3)):
        path.write_bytes(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, vertices, 1.0, 1.0, samples))
        with pytest.raises(DamagedCacheError):
            point_cache.read_header(path)


# -- disks -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.ENOSPC, "The disk is full: .* bake again"),
        (errno.EROFS, "may not be written"),
        (errno.EIO, "Choose another path"),
    ],
)
def test_errors_of_the_disk_are_told_and_leave_the_old_file(tmp_path, monkeypatch, number, words):
    rows = shapes(2)
    path = tmp_path / "a.pc2"
    write(path, rows)
    kept = path.read_bytes()

    def refuse(_file):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(whole_files.os, "fsync", refuse)
    with pytest.raises(CacheError, match=words):
        write(path, 2.0 * rows)
    assert path.read_bytes() == kept
    assert left_behind(tmp_path) == []


def test_what_killed_processes_left_is_taken_away_and_what_is_written_is_not(tmp_path):
    old, new, other = (tmp_path / name for name in ("[a].tmp.12345678", "[a].tmp.87654321", "a.tmp.12345678"))
    for path in (old, new, other):
        path.write_text("half")
    long_ago = time.time() - 2 * whole_files.ABANDONED_SECONDS
    for path in (old, other):
        os.utime(path, (long_ago, long_ago))
    write(tmp_path / "[a]", shapes(1))
    assert [path.exists() for path in (old, new, other)] == [False, True, True]


# -- chunks ----------------------------------------------------------------------------------------------------------


def filled(folder, rows, chunk=4, key="key", first=1):
    store = FARM.ChunkStore(folder, key, range(first, first + len(rows)))
    for begin in range(0, len(rows), chunk):
        part = rows[begin : begin + chunk]
        store.write(first + begin, part, [f"of {first + begin + row}" for row in range(len(part))])
    return store


@pytest.mark.parametrize("first", [1, -6])
@pytest.mark.parametrize("chunk", [1, 4, 100])
def test_merged_chunks_are_the_cache_written_at_once(tmp_path, chunk, first):
    rows = shapes(10)
    store = filled(tmp_path / "chunks", rows, chunk, first=first)
    assert store.missing() == []
    problems = store.merge(tmp_path / "merged.pc2", header(rows, first))
    write(tmp_path / "at_once.pc2", rows, first)
    assert (tmp_path / "merged.pc2").read_bytes() == (tmp_path / "at_once.pc2").read_bytes()
    assert problems == [f"of {number}" for number in range(first, first + 10)]


def test_chunks_that_overlap(tmp_path):
    rows = shapes(10)
    store = FARM.ChunkStore(tmp_path, "key", range(-5, 5))
    for first, count in ((-3, 2), (-5, 6), (-1, 3)):
        store.write(first, rows[first + 5 : first + 5 + count], [f"of {first + row}" for row in range(count)])
    assert store.missing() == [2, 3, 4]
    with pytest.raises(FARM.IncompleteError, match="3 of 10 frames are not baked yet, the first is 2"):
        store.merge(tmp_path / "out.pc2", header(rows))
    store.write(2, rows[7:], ["of 2", "of 3", "of 4"])
    problems = store.merge(tmp_path / "out.pc2", header(rows))
    assert np.array_equal(point_cache.mapped(tmp_path / "out.pc2"), rows)
    assert problems == [f"of {frame}" for frame in range(-5, 5)]


def test_chunks_of_another_key_do_not_count(tmp_path):
    filled(tmp_path, shapes(4))
    assert FARM.ChunkStore(tmp_path, "other", range(1, 5)).missing() == [1, 2, 3, 4]
    assert FARM.ChunkStore(tmp_path, "key", range(2, 4)).missing() == []


@pytest.mark.parametrize("damage", ["a bit", "cut", "empty", "another", "other vertices"])
def test_a_damaged_chunk_is_told_and_taken_out(tmp_path, damage):
    rows = shapes(8)
    store = filled(tmp_path / "chunks", rows)
    path = tmp_path / "chunks" / "key_+000005_+000008.npz"
    content = bytearray(path.read_bytes())
    content[300] ^= 1  # of a coordinate
    if damage == "other vertices":
        store.write(5, shapes(4, 8), [""] * 4)
    elif damage == "another":
        np.save(path.open("wb"), rows)
    else:
        path.write_bytes({"a bit": content, "cut": content[:-1], "empty": b""}[damage])
    (tmp_path / "out.pc2").write_bytes(b"old")
    with pytest.raises(DamagedCacheError, match=r"000005_\+000008"):
        store.merge(tmp_path / "out.pc2", header(rows))
    assert (tmp_path / "out.pc2").read_bytes() == b"old"
    assert store.missing() == [5, 6, 7, 8]
    assert left_behind(tmp_path) == []


@pytest.mark.parametrize("text", ["", "{", "[]", "\x00", 100_000 * "["])
def test_markers_that_make_no_sense_say_nothing(tmp_path, text):
    (tmp_path / "a.pc2.json").write_text(text)
    assert point_cache.read_marker(tmp_path / "a.pc2") == {}


def begun(folder, rows, key="key"):
    return point_cache.Begun(folder / "out.pc2", key, header(rows))


def test_what_was_begun_goes_on_and_becomes_the_cache(tmp_path):
    rows = shapes(10)
    write(tmp_path / "at_once.pc2", rows)
    begun(tmp_path, rows).write(0, rows[:4], ["", "a", "", ""])
    assert begun(tmp_path, rows).problems == ["", "a", "", ""] and begun(tmp_path, rows, "other").problems == []
    again = begun(tmp_path, rows)
    with again.path.open("ab") as file:
        file.write(b"half of a sample")
    again.write(4, rows[4:], [""] * 6)
    assert not (tmp_path / "out.pc2").exists()
    begun(tmp_path, rows, "other").write(0, rows[:1], [""])
    behind = begun(tmp_path, rows)  # as of another Blender that bakes the same
    again.become_whole()
    assert (tmp_path / "out.pc2").read_bytes() == (tmp_path / "at_once.pc2").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["at_once.pc2", "out.pc2"]
    for too_late in (behind.become_whole, lambda: behind.write(10, rows, [""] * 10)):
        with pytest.raises(DamagedCacheError, match="Bake again"):
            too_late()
    assert (tmp_path / "out.pc2").read_bytes() == (tmp_path / "at_once.pc2").read_bytes()


@pytest.mark.parametrize("damage", ["cut", "gone", "no list"])
def test_what_was_begun_and_is_not_whole_begins_anew(tmp_path, damage):
    rows = shapes(4)
    one = begun(tmp_path, rows)
    one.write(0, rows, [""] * 4)
    if damage == "no list":
        point_cache.write_marker(one.path, {"problems": 3})
    else:
        one.path.write_bytes(one.path.read_bytes()[:-1] if damage == "cut" else b"")
    assert begun(tmp_path, rows).problems == []


BAKER = """
import pathlib, sys
import numpy as np
sys.path.insert(0, sys.argv[1])
from addon.baking.core import point_cache
from addon.scene.core import whole_files

whole_files.ABANDONED_SECONDS = -1  # nobody else is at work
begun = point_cache.Begun(pathlib.Path(sys.argv[2], "out.pc2"), "key", point_cache.Header(2000, 1.0, 1.0, 60))
for begin in range(len(begun.problems), 60, 6):
    numbers = range(begin, begin + 6)
    rows = np.stack([np.random.default_rng(number).standard_normal((2000, 3)) for number in numbers])
    begun.write(begin, rows, [""] * 6)
begun.become_whole()
"""


@pytest.mark.slow
def test_killed_at_random_moments_it_goes_on_to_the_same_bytes(tmp_path):
    def start(folder):
        folder.mkdir(exist_ok=True)
        return subprocess.Popen([sys.executable, "-c", BAKER, ROOT, folder])

    whole = start(tmp_path / "whole")
    begun = time.monotonic()
    assert whole.wait() == 0
    seconds = time.monotonic() - begun
    wanted = (tmp_path / "whole" / "out.pc2").read_bytes()
    chance = random.Random(5)
    folder = tmp_path / "killed"
    cut_short = 0
    for _ in range(20):
        baker = start(folder)
        time.sleep(seconds * chance.uniform(0.2, 1.1))
        baker.kill()
        cut_short += baker.wait() != 0
        if (folder / "out.pc2").exists():  # never a half file under the final name
            assert (folder / "out.pc2").read_bytes() == wanted
            for path in folder.rglob("*"):  # begin anew
                if path.is_file() and chance.random() < 0.5:
                    path.unlink()
    assert cut_short >= 5
    assert start(folder).wait() == 0
    assert (folder / "out.pc2").read_bytes() == wanted
    assert left_behind(folder) == []


# -- times of samples, and which frames are kept as keys ---------------------------------------------------------------


def test_times():
    assert bake_times.sample_times(1, 4).tolist() == [1, 2, 3, 4]
    assert bake_times.sample_times(1, 2, samples=4).tolist() == [1, 1.25, 1.5, 1.75, 2]
    assert bake_times.sample_times(3, 3).tolist() == [3]
    with pytest.raises(SceneError, match="ends before it begins"):
        bake_times.sample_times(4, 1)


def test_straight_motion_needs_two_keys_and_each_corner_one():
    times = np.arange(31.0)
    path = np.interp(times, [0, 10, 30], [0.0, 5.0, -5.0])
    rows = np.zeros((31, 4, 3), np.float32)
    rows[:, 2, 1] = path
    assert result_of(bake_times.reduced(rows, times, 1e-4)) == [0, 10, 30]
    assert result_of(bake_times.reduced(rows[:11], times, 1e-4)) == [0, 10]
    assert result_of(bake_times.reduced(rows[:1], times, 1e-4)) == [0]


@pytest.mark.parametrize("tolerance", [0.0, 0.001, 0.05, 1.0])
def test_every_row_is_within_the_tolerance(tolerance):
    times = np.sort(np.random.default_rng(2).uniform(0, 40, 60))
    phase = np.linspace(0, 6, 5)[None, :, None]
    rows = np.sin(0.3 * times[:, None, None] + phase * [1, 2, 3]).astype(np.float32)
    kept = result_of(bake_times.reduced(rows, times, tolerance))
    assert kept[0] == 0
    assert kept[-1] == 59
    assert kept == sorted(set(kept))
    blends = [np.interp(times, times[kept], path) for path in rows[kept].reshape(len(kept), -1).T]
    off = np.linalg.norm(np.stack(blends, axis=1).reshape(rows.shape) - rows, axis=2)
    assert off.max() <= tolerance + 1e-6
    if tolerance >= 0.05:
        assert len(kept) < 40
    if tolerance == 0.0:
        assert len(kept) == 60
