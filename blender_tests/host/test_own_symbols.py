# SPDX-License-Identifier: GPL-3.0-or-later
"""packaging/own_symbols.py, on a library for macOS of headers, a page and a signature alone."""

import hashlib
import pathlib
import struct
import sys

import pytest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "packaging"))
import own_symbols

PAGE = 4096


def library():
    """The bytes, and where the signature is."""
    commands = struct.pack("<2I10I", 0x80000022, 48, *range(1, 11)) + struct.pack("<4I", 0x1D, 16, PAGE, 0)
    header = struct.pack("<8I", own_symbols.MAGIC, 0x0100000C, 0, 6, 2, len(commands), 0x118085, 0)
    directory = struct.pack(">9I4B", own_symbols.CODE_DIRECTORY, 72, 0x20400, 2, 40, 0, 0, 1, PAGE, 32, 2, 0, 12)
    signature = struct.pack(">5I", 0xFADE0CC0, 92, 1, 0, 20) + directory + bytes(32)
    return bytearray((header + commands).ljust(PAGE, b"\1") + signature)


def test_nothing_is_looked_for_elsewhere_and_the_signature_fits():
    data = library()
    own_symbols.keep_to_own(data)
    assert struct.unpack_from("<I", data, 24)[0] == 0x100085
    assert struct.unpack_from("<10I", data, 40) == (1, 2, 3, 4, 0, 0, 7, 8, 9, 10)
    assert data[-32:] == hashlib.sha256(data[:PAGE]).digest()
    assert len(data) == len(library())


def test_what_is_no_such_library_or_signed_otherwise_is_refused():
    with pytest.raises(ValueError, match="no library for macOS"):
        own_symbols.keep_to_own(bytearray(b"\x7fELF" + bytes(64)))
    data = library()
    data[PAGE + 20 + 37] = 1
    with pytest.raises(ValueError, match="SHA-256"):
        own_symbols.keep_to_own(data)
