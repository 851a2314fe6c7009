#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a library for macOS keep to its own C++ symbols: own_symbols.py LIBRARY

Zig's linker lists weak symbols (vtables, types of exceptions, parts of libc++) for the system to look up in all
libraries of the process. Hidden ones are in none, so the look-up would fail. The references point to the library's own
symbols already. This drops the list, and signs the library again if it was signed.
"""

import hashlib
import pathlib
import struct
import sys

MAGIC = 0xFEEDFACF  # 64 bits, little-endian
WEAK_DEFINES, BINDS_TO_WEAK = 0x8000, 0x10000
CODE_SIGNATURE, DYLD_INFO = 0x1D, 0x22
REQUIRED = 0x80000000  # a bit of commands that the system has to know
CODE_DIRECTORY = 0xFADE0C02


def keep_to_own(data):
    """Changes the bytearray of a library. @throws ValueError if it is none."""
    if struct.unpack_from("<I", data)[0] != MAGIC:
        raise ValueError("no library for macOS")
    count, _, flags = struct.unpack_from("<III", data, 16)
    struct.pack_into("<I", data, 24, flags & ~(WEAK_DEFINES | BINDS_TO_WEAK))
    offset, signature = 32, None
    for _ in range(count):
        command, size = struct.unpack_from("<II", data, offset)
        if command & ~REQUIRED == DYLD_INFO:
            struct.pack_into("<II", data, offset + 24, 0, 0)  # where the weak ones are, and how many bytes
        elif command == CODE_SIGNATURE:
            signature = struct.unpack_from("<I", data, offset + 8)[0]
        offset += size
    if signature is not None:
        sign(data, signature)


def sign(data, signature):
    """Writes the SHA-256 of every page into the code directories of the signature at that offset."""
    (blobs,) = struct.unpack_from(">I", data, signature + 8)
    for index in range(blobs):
        _, offset = struct.unpack_from(">II", data, signature + 12 + 8 * index)
        directory = signature + offset
        if struct.unpack_from(">I", data, directory)[0] != CODE_DIRECTORY:
            continue
        fields = struct.unpack_from(">IIIIIBBBB", data, directory + 16)
        hashes, _, _, pages, end, hash_size, hash_type, _, page_bits = fields
        if (hash_size, hash_type) != (32, 2):
            raise ValueError("its signature is not of SHA-256")
        for page in range(pages):
            content = data[page << page_bits : min((page + 1) << page_bits, end)]
            place = directory + hashes + page * hash_size
            data[place : place + hash_size] = hashlib.sha256(content).digest()


if __name__ == "__main__":
    path = pathlib.Path(sys.argv[1])
    content = bytearray(path.read_bytes())
    keep_to_own(content)
    path.write_bytes(content)
