# SPDX-License-Identifier: GPL-3.0-or-later
"""The animated pictures of the demo, read back by the rules of PNG and APNG."""

import pathlib
import struct
import zlib

import numpy as np
import pytest
from demo import animated_png

README_PICTURE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "pictures" / "octopus_lift.png"
MOST_BYTES = 1_500_000


def chunks(data):
    assert data.startswith(animated_png.SIGNATURE)
    place = len(animated_png.SIGNATURE)
    while place < len(data):
        (length,) = struct.unpack_from(">I", data, place)
        kind, body = data[place + 4 : place + 8], data[place + 8 : place + 8 + length]
        (check,) = struct.unpack_from(">I", data, place + 8 + length)
        assert check == zlib.crc32(kind + body)
        yield kind, body
        place += 12 + length


def shown(data):
    """[(height, width, 3) uint8] that a viewer shows one after another."""
    found = list(chunks(data))
    head = dict(found)
    width, height = struct.unpack_from(">II", head[b"IHDR"])
    colours = np.frombuffer(head[b"PLTE"], np.uint8).reshape(-1, 3)
    is_clear = np.frombuffer(head[b"tRNS"], np.uint8) == 0
    canvas = np.zeros((height, width, 3), np.uint8)
    frames, numbers, control = [], [], None
    for kind, body in found:
        if kind == b"fcTL":
            control = struct.unpack(">IIIIIHHBB", body)
            numbers.append(control[0])
        elif kind in {b"IDAT", b"fdAT"}:
            if kind == b"fdAT":
                numbers.append(struct.unpack_from(">I", body)[0])
                body = body[4:]
            columns, rows, x, y = control[1:5]
            lines = np.frombuffer(zlib.decompress(body), np.uint8).reshape(rows, columns + 1)
            assert not lines[:, 0].any()  # no filter
            part, pixels = canvas[y : y + rows, x : x + columns], lines[:, 1:]
            part[~is_clear[pixels]] = colours[pixels[~is_clear[pixels]]]
            frames.append(canvas.copy())
    assert numbers == list(range(len(numbers)))
    assert struct.unpack(">II", head[b"acTL"]) == (len(frames), 0)  # for ever
    return frames


def moving_disc(steps=6, size=64):
    rows, columns = np.mgrid[:size, :size]
    for step in range(steps):
        frame = np.zeros((size, size, 3), np.uint8)
        frame[:, :, 2] = 2 * rows + 60  # a backdrop that goes from colour to colour
        frame[(rows - 32) ** 2 + (columns - 16 - 6 * step) ** 2 < 80] = (220, 120, 30)
        yield frame


def test_what_is_shown_is_what_was_given(tmp_path):
    frames = list(moving_disc())
    animated_png.write(tmp_path / "disc.png", frames, 0.1)
    read = shown((tmp_path / "disc.png").read_bytes())
    assert len(read) == len(frames)
    for given, seen in zip(frames, read, strict=True):
        assert np.abs(given.astype(int) - seen).max() <= animated_png.NOISE + 6


def test_frames_of_one_picture_take_no_room(tmp_path):
    (frame, *_rest) = moving_disc()
    animated_png.write(tmp_path / "one.png", [frame], 0.1)
    animated_png.write(tmp_path / "ten.png", [frame] * 10, 0.1)
    assert (tmp_path / "ten.png").stat().st_size < (tmp_path / "one.png").stat().st_size + 10 * 100
    first, *others = shown((tmp_path / "ten.png").read_bytes())
    assert all(np.array_equal(each, first) for each in others)


@pytest.mark.parametrize("count", [1, 3, 300, 5000])
def test_a_palette_holds_few_colours_exactly(count):
    pixels = np.random.default_rng(1).integers(0, 256, (count, 3)).astype(np.uint8)
    colours = animated_png.palette(pixels)
    assert colours.shape == (animated_png.COLOURS, 3)
    near = colours[animated_png.nearest(pixels[None], colours)[0]].astype(int)
    farthest = np.abs(near - pixels).max()
    assert farthest == 0 if count <= 3 else farthest < 90


def test_the_picture_of_readme_moves_and_is_small():
    assert README_PICTURE.stat().st_size < MOST_BYTES
    frames = shown(README_PICTURE.read_bytes())
    middle = len(frames) // 2
    changed = (np.abs(frames[0].astype(int) - frames[middle]) > 30).any(axis=2)
    assert len(frames) >= 12
    assert 0.005 < changed.mean() < 0.3  # the tentacle, and not the rest
