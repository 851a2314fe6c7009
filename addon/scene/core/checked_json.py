# SPDX-License-Identifier: GPL-3.0-or-later
"""Dicts in JSON files that are there whole or not at all; a checksum tells where anything else has written to them."""

import hashlib
import json
import pathlib

from . import whole_files


def write_checked_json(path, value):
    """@throws CacheError."""
    with whole_files.replacing(path) as file:
        file.write(json.dumps({**value, "checksum": _checksum(value)}).encode())


def read_checked_json(path):
    """A dict as write_checked_json() wrote it; None if there is none, or one that anything else has written to."""
    try:
        value = json.loads(pathlib.Path(path).read_bytes())
    except (OSError, ValueError, RecursionError, MemoryError):
        return None
    told = value.pop("checksum", None) if isinstance(value, dict) else None
    return value if told is not None and told == _checksum(value) else None


def _checksum(value):
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()
