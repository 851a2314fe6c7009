# SPDX-License-Identifier: GPL-3.0-or-later
"""Dicts in JSON files that are there whole or not at all; a checksum tells where anything else has written to them."""

import hashlib
import json
import pathlib

from . import whole_files


def write_json(path, value):
    """@throws CacheError."""
    with whole_files.replacing(path) as file:
        file.write(json.dumps(value, indent=None, allow_nan=True).encode())


def write_checked_json(path, value):
    """As write_json(), with a checksum of the rest in it. @throws CacheError."""
    write_json(path, {**value, "checksum": _checksum(value)})


def read_checked_json(path):
    """A dict as write_checked_json() wrote it; None if there is none, or one that anything else has written to."""
    value = read_json(path) or {}
    told = value.pop("checksum", None)
    return value if told == _checksum(value) else None


def _checksum(value):
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()


def read_json(path):
    """A dict, or None if there is none that can be read."""
    try:
        value = json.loads(pathlib.Path(path).read_bytes())
    except (OSError, ValueError, RecursionError, MemoryError):
        return None
    return value if isinstance(value, dict) else None
