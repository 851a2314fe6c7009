# SPDX-License-Identifier: GPL-3.0-or-later
"""Animated PNG (APNG) of few colours: small enough for a page. No bpy."""

import struct
import zlib

import numpy as np

SIGNATURE = b"\x89PNG\r\n\x1a\n"
COLOURS = 255
UNCHANGED = COLOURS  # number of the transparent colour: the pixel stays as it was
NOISE = 7  # a pixel that changes less in every channel, of 255, stays


def write(path, frames, seconds):
    """frames: [(height, width, 3) uint8, top row first], all of one size; seconds: how long each is shown. Loops."""
    colours = palette(np.concatenate([frame[::3, ::3].reshape(-1, 3) for frame in frames]))
    height, width = frames[0].shape[:2]
    chunks = [
        _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)),
        _chunk(b"PLTE", np.vstack([colours, np.zeros((1, 3), np.uint8)]).tobytes()),
        _chunk(b"tRNS", bytes([255] * COLOURS + [0])),
        _chunk(b"acTL", struct.pack(">II", len(frames), 0)),
    ]
    shown, count = None, 0
    for frame in frames:
        rows, columns, numbers, shown = _difference(frame, shown, colours)
        place = (numbers.shape[1], numbers.shape[0], columns, rows)
        delay = (round(1000 * seconds), 1000)
        chunks.append(_chunk(b"fcTL", struct.pack(">IIIIIHHBB", count, *place, *delay, 0, 1)))
        lines = np.hstack([np.zeros((len(numbers), 1), np.uint8), numbers])  # each line unfiltered
        pixels = zlib.compress(lines.tobytes(), 9)
        if count == 0:
            chunks.append(_chunk(b"IDAT", pixels))
            count = 1
        else:
            chunks.append(_chunk(b"fdAT", struct.pack(">I", count + 1) + pixels))
            count += 2
    chunks.append(_chunk(b"IEND", b""))
    path.write_bytes(SIGNATURE + b"".join(chunks))


def palette(pixels):
    """(COLOURS, 3) uint8 by median cut: the box of colours that is longest and fullest is halved, again and again."""
    boxes = [_measured(pixels.astype(np.int32))]
    while len(boxes) < COLOURS:
        size, box = boxes.pop(max(range(len(boxes)), key=lambda number: boxes[number][0]))
        if size == 0.0:  # every box is of one colour
            boxes.append((size, box))
            break
        order = np.argsort(box[:, np.ptp(box, axis=0).argmax()], kind="stable")
        boxes += [_measured(box[half]) for half in np.array_split(order, 2)]
    colours = np.zeros((COLOURS, 3), np.uint8)
    colours[: len(boxes)] = [box.mean(axis=0).round() for _size, box in boxes]
    return colours


def _measured(box):
    return float(np.ptp(box, axis=0).max() * np.sqrt(len(box))), box


def nearest(pixels, colours):
    """Numbers of the nearest colours, (height, width) uint8; each colour that occurs is looked for once."""
    flat, inverse = np.unique(pixels.reshape(-1, 3), axis=0, return_inverse=True)
    squares = (colours.astype(np.int64) ** 2).sum(axis=1)
    found = [
        (squares - 2 * (part.astype(np.int64) @ colours.T.astype(np.int64))).argmin(axis=1)
        for part in np.array_split(flat, max(1, len(flat) // 20000))
    ]
    return np.concatenate(found)[inverse.ravel()].astype(np.uint8).reshape(pixels.shape[:2])


def _difference(frame, shown, colours):
    """(first row, first column, numbers of the part that changes, what is shown then)."""
    if shown is None:
        return 0, 0, nearest(frame, colours), frame
    changed = (np.abs(frame.astype(np.int16) - shown) > NOISE).any(axis=2)
    if not changed.any():
        changed[0, 0] = True
    rows, columns = np.flatnonzero(changed.any(axis=1)), np.flatnonzero(changed.any(axis=0))
    part = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    numbers = np.where(changed[part], nearest(frame[part], colours), np.uint8(UNCHANGED))
    return rows[0], columns[0], numbers, np.where(changed[:, :, None], frame, shown)


def _chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
