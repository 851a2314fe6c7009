# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/: point caches, chunks and their markers, lists of frames: whole files or none, whatever happens."""

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

from addon.baking.core import point_cache
from addon.baking.core.chunk_store import ChunkStore
from addon.errors import CacheError, DamagedCacheError, IncompleteCacheError
from addon.scene.core import whole_files
from addon.solver.core.steps import result_of

ROOT = pathlib.Path(__file__).resolve().parents[2]


def shapes(frames, vertices=7, seed=0):
    return np.random.default_rng(seed).standard_normal((frames, vertices, 3)).astype(np.float32)


def header(rows, start=1.0, rate=1.0):
    return point_cache.Header(rows.shape[1], start, rate, len(rows))


def left_behind(folder):
    return [path.name for path in pathlib.Path(folder).rglob("*.tmp.*")]


# -- the format ------------------------------------------------------------------------------------------------------


def test_the_bytes_are_those_of_the_format(tmp_path):
    rows = shapes(3)
    point_cache.write(tmp_path / "a.pc2", header(rows, -2.5, 0.5), rows)
    content = (tmp_path / "a.pc2").read_bytes()
    assert content[:12] == b"POINTCACHE2\0"
    assert struct.unpack("<iiffi", content[12:32]) == (1, 7, -2.5, 0.5, 3)
    assert content[32:] == rows.astype("<f4").tobytes()


def test_what_is_written_is_read(tmp_path):
    rows = shapes(5)
    path = tmp_path / "deep" / "a.pc2"
    point_cache.write(path, header(rows), rows)
    assert point_cache.read_header(path) == header(rows)
    assert np.array_equal(point_cache.mapped(path), rows)
    assert np.array_equal(np.concatenate(list(point_cache.portions(path))), rows)
    assert left_behind(tmp_path) == []


def test_float64_is_rounded_and_a_wrong_number_of_rows_leaves_nothing(tmp_path):
    rows = shapes(2)
    point_cache.write(tmp_path / "a.pc2", header(rows), rows.astype(np.float64))
    assert np.array_equal(point_cache.mapped(tmp_path / "a.pc2"), rows)
    for wrong in (rows[:1], shapes(2, 8)):
        with pytest.raises(ValueError, match="samples=2"):
            point_cache.write(tmp_path / "b.pc2", header(rows), wrong)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.pc2"]


@pytest.mark.parametrize("length", [0, 5, 31, 32, 100])
def test_truncated_files_are_told(tmp_path, length):
    rows = shapes(3)
    path = tmp_path / "a.pc2"
    point_cache.write(path, header(rows), rows)
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
        (errno.ENOSPC, "The disk is full: .* are free, 200 bytes are needed"),
        (errno.EROFS, "may not be written"),
        (errno.EIO, "Choose another path"),
    ],
)
def test_errors_of_the_disk_are_told_and_leave_the_old_file(tmp_path, monkeypatch, number, words):
    rows = shapes(2)
    path = tmp_path / "a.pc2"
    point_cache.write(path, header(rows), rows)
    kept = path.read_bytes()

    def refuse(_file):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(whole_files.os, "fsync", refuse)
    with pytest.raises(CacheError, match=words):
        point_cache.write(path, header(rows), 2.0 * rows)
    assert path.read_bytes() == kept
    assert left_behind(tmp_path) == []


def test_what_killed_processes_left_is_taken_away_and_what_runs_is_not(tmp_path):
    host = whole_files.socket.gethostname()
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    dead = tmp_path / f"a.tmp.{host}.{ended.pid}"
    running = tmp_path / f"a.tmp.{host}.{os.getppid()}"
    elsewhere = tmp_path / "a.tmp.elsewhere.1"
    old = tmp_path / "a.tmp.elsewhere.2"
    for path in (dead, running, elsewhere, old):
        path.write_text("half")
    long_ago = time.time() - 2 * whole_files.ABANDONED_SECONDS
    os.utime(old, (long_ago, long_ago))
    with whole_files.replacing(tmp_path / "a") as file:
        file.write(b"whole")
    is_told = os.name == "posix"  # elsewhere a file has to be old
    assert [path.exists() for path in (dead, running, elsewhere, old)] == [not is_told, True, True, False]


# -- chunks ----------------------------------------------------------------------------------------------------------


def filled(folder, rows, chunk=4, key="key", first=1):
    store = ChunkStore(folder, key, range(first, first + len(rows)), rows.shape[1])
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
    problems = result_of(store.merge(tmp_path / "merged.pc2", header(rows, first)))
    point_cache.write(tmp_path / "at_once.pc2", header(rows, first), rows)
    assert (tmp_path / "merged.pc2").read_bytes() == (tmp_path / "at_once.pc2").read_bytes()
    assert problems == [f"of {number}" for number in range(first, first + 10)]


def test_chunks_that_overlap(tmp_path):
    rows = shapes(10)
    store = ChunkStore(tmp_path, "key", range(-5, 5), 7)
    for first, count in ((-3, 2), (-5, 6), (-1, 3)):
        store.write(first, rows[first + 5 : first + 5 + count], [f"of {first + row}" for row in range(count)])
    assert store.missing() == [2, 3, 4]
    with pytest.raises(IncompleteCacheError, match="3 of 10 frames are not baked yet, the first is 2"):
        result_of(store.merge(tmp_path / "out.pc2", header(rows)))
    store.write(2, rows[7:], ["of 2", "of 3", "of 4"])
    problems = result_of(store.merge(tmp_path / "out.pc2", header(rows)))
    assert np.array_equal(point_cache.mapped(tmp_path / "out.pc2"), rows)
    assert problems == [f"of {frame}" for frame in range(-5, 5)]


def test_chunks_of_another_key_or_mesh_do_not_count(tmp_path):
    rows = shapes(4)
    filled(tmp_path, rows)
    assert ChunkStore(tmp_path, "other", range(1, 5), 7).missing() == [1, 2, 3, 4]
    assert ChunkStore(tmp_path, "key", range(1, 5), 8).missing() == [1, 2, 3, 4]
    assert ChunkStore(tmp_path, "key", range(2, 4), 7).missing() == []


def test_data_without_a_marker_with_a_damaged_header_or_cut_do_not_count(tmp_path):
    store = filled(tmp_path, shapes(8))
    path = tmp_path / "+000005_+000008.pc2"
    content = path.read_bytes()
    path.write_bytes(b"X" + content[1:])
    assert store.missing() == [5, 6, 7, 8]
    path.write_bytes(content[:-1])
    (tmp_path / "+000001_+000004.json").unlink()
    assert store.missing() == list(range(1, 9))


def test_a_damaged_chunk_is_told_and_taken_out(tmp_path):
    rows = shapes(8)
    store = filled(tmp_path / "chunks", rows)
    path = tmp_path / "chunks" / "+000005_+000008.pc2"
    content = bytearray(path.read_bytes())
    content[100] ^= 1
    path.write_bytes(content)
    (tmp_path / "out.pc2").write_bytes(b"old")
    with pytest.raises(DamagedCacheError, match="5 to 8"):
        result_of(store.merge(tmp_path / "out.pc2", header(rows)))
    assert (tmp_path / "out.pc2").read_bytes() == b"old"
    assert store.missing() == [5, 6, 7, 8]
    assert left_behind(tmp_path) == []


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", '{"schema": 1}', "\x00"])
def test_markers_that_make_no_sense_do_not_count(tmp_path, text):
    store = filled(tmp_path, shapes(4))
    (tmp_path / "+000001_+000004.json").write_text(text)
    assert store.missing() == [1, 2, 3, 4]


BAKER = """
import sys, time
import numpy as np
sys.path.insert(0, sys.argv[1])
from addon.baking.core import point_cache
from addon.baking.core.chunk_store import ChunkStore

store = ChunkStore(sys.argv[2] + "/out.chunks", "key", range(1, 61), 2000)
missing = store.missing()
for begin in range(1, 61, 6):
    numbers = list(range(begin, begin + 6))
    if begin not in missing:
        continue
    rows = np.stack([np.random.default_rng(number).standard_normal((2000, 3)) for number in numbers])
    store.write(begin, rows, [""] * 6)
for _ in store.merge(sys.argv[2] + "/out.pc2", point_cache.Header(2000, 1.0, 1.0, 60)):
    pass
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
