# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/baking/core/chunk_store.py: chunks that were stopped on their way, and what is told of them."""

import pathlib
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from addon.baking.core.chunk_store import ChunkStore

FRAMES = range(1, 13)
CHUNK = list(range(7, 13))
STATE = np.random.default_rng(1).integers(0, 256, 5000).astype(np.uint8)


def store(folder, key="key", vertices=4, frames=FRAMES):
    return ChunkStore(folder / "a.chunks", key, frames, vertices)


@pytest.fixture
def begun(tmp_path):
    store(tmp_path).keep_begun(CHUNK, STATE, [7, 8, 10])
    return tmp_path


def only_file(folder):
    (path,) = (folder / "a.chunks").iterdir()
    return path


def test_what_was_kept_is_given_back(begun):
    state, solved = store(begun).begun(CHUNK)
    assert np.array_equal(state, STATE) and solved == [7, 8, 10]
    assert store(begun).kept([CHUNK]) == [7, 8, 10]
    assert store(begun).missing() == list(FRAMES), "they are no chunk yet"


def test_chunks_and_what_is_begun_count_together(begun):
    store(begun).write(range(1, 7), np.zeros((6, 4, 3)), {})
    assert store(begun).kept([CHUNK]) == [1, 2, 3, 4, 5, 6, 7, 8, 10]
    assert store(begun, frames=[6, 7, 9]).kept([[7, 9]]) == [6], "another part does not go on with it"


def test_a_chunk_that_is_whole_takes_its_place(begun):
    store(begun).write(CHUNK, np.zeros((6, 4, 3)), {})
    assert store(begun).begun(CHUNK) == (None, [])
    assert store(begun).kept([CHUNK]) == CHUNK


@pytest.mark.parametrize("other", [{"key": "another"}, {"vertices": 5}])
def test_of_something_else_it_is_nothing(begun, other):
    assert store(begun, **other).begun(CHUNK) == (None, [])
    assert store(begun, **other).kept([CHUNK]) == []


def test_another_chunk_does_not_go_on_with_it(begun):
    assert store(begun).begun([7, 8, 9]) == (None, [])


def test_later_it_is_replaced_and_with_the_rest_removed(begun):
    store(begun).keep_begun(CHUNK, STATE[:10], CHUNK[:5])
    assert store(begun).begun(CHUNK)[1] == CHUNK[:5]
    only_file(begun)
    store(begun).remove()
    assert list(begun.iterdir()) == []


def test_damaged_at_any_place_it_is_nothing(begun):
    path = only_file(begun)
    content = path.read_bytes()
    for place in (0, 5, 40, content.index(b"\n"), content.index(b"\n") + 1, len(content) - 1):
        path.write_bytes(content[:place] + bytes([content[place] ^ 4]) + content[place + 1 :])
        assert store(begun).begun(CHUNK) == (None, []), place
    for length in (0, 1, 50, len(content) - 1):
        path.write_bytes(content[:length])
        assert store(begun).begun(CHUNK) == (None, [])
        assert store(begun).kept([CHUNK]) == []
    path.write_bytes(content + b"x")
    assert store(begun).kept([CHUNK]) == []
