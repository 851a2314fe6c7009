# SPDX-License-Identifier: GPL-3.0-or-later
"""A display without a screen (Xvfb), that can be photographed from outside, even when what draws on it hangs."""

import os
import pathlib
import struct
import subprocess
import tempfile
import time
import zlib

import numpy as np

SIZE = (1280, 800)
END_SECONDS = 60
SETTLE_SECONDS = 2.0
LOOK_SECONDS = 0.03


class Display:
    """Context manager; `name` is for the environment's DISPLAY."""

    def __enter__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="meanvalue-display-")
        reading, writing = os.pipe()
        try:
            # Xvfb looks for a free number itself and tells it once it accepts programs.
            screen = f"Xvfb -screen 0 {SIZE[0]}x{SIZE[1]}x24 +extension GLX -nolisten tcp"
            self._server = subprocess.Popen(
                [*screen.split(), "-displayfd", str(writing), "-fbdir", self._folder.name],
                pass_fds=[writing],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        finally:
            os.close(writing)
        with os.fdopen(reading) as pipe:
            number = pipe.readline().strip()
        assert number, "Xvfb did not start"
        self.name = f":{number}"
        self.file = pathlib.Path(self._folder.name, "Xvfb_screen0")
        return self

    def __exit__(self, *_):
        self._server.terminate()
        try:
            self._server.wait(END_SECONDS)
        except subprocess.TimeoutExpired:
            self._server.kill()
            self._server.wait()
        self._folder.cleanup()


def photograph(file, path):
    """Writes what is on the display whose `file` it is as a PNG. Returns how many colours it has.

    Taken from outside of Blender, whose own screenshots are black on such a display from 4.0 on.
    """
    colours = _colours(_settled(file))
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(_png(colours))
    return len(np.unique(colours.astype(np.uint32) @ [1 << 16, 1 << 8, 1]))


def _settled(file):
    """The display draws what it is asked for a little later: its content when that has not changed for a moment."""
    data, until = None, time.monotonic() + SETTLE_SECONDS
    while (newer := file.read_bytes()) != data and time.monotonic() < until:
        data = newer
        time.sleep(LOOK_SECONDS)
    return newer


def _colours(data):
    """(height, width, 3) uint8 of an X window dump with 32 bits a pixel: blue, green, red, unused."""
    header = struct.unpack(">25I", data[:100])
    start, width, height, row_bytes = header[0] + 12 * header[19], header[4], header[5], header[12]
    pixels = np.frombuffer(data[start : start + height * row_bytes], np.uint8).reshape(height, -1, 4)
    return pixels[:, :width, 2::-1]


def _png(colours):
    height, width, _ = colours.shape
    rows = np.pad(colours.reshape(height, -1), ((0, 0), (1, 0)))  # each begins with how it is filtered: not at all

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(rows.tobytes())) + chunk(b"IEND", b"")
