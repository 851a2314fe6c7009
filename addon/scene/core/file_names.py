# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of files that every system takes. A scene goes from one system to another, so the rules are the same on all."""

import pathlib
import re

#: With any ending Windows takes them for devices.
_DEVICE = re.compile(r"^(con|prn|aux|nul|com[0-9¹²³]|lpt[0-9¹²³])(?=\.|$)", re.IGNORECASE)
_REFUSED = re.compile(r'[<>:"/\\|?*\x00-\x1f]')
#: Windows takes no more, unless it was told to, and a cache has longer names beside it while it is written.
_MOST_ON_WINDOWS = 259 - 60


def file_name(name):
    """`name` of an object or a clip, without an ending, as that of a file or folder."""
    return _DEVICE.sub(r"\1_", _REFUSED.sub("_", name).rstrip(". ")) or "_"


def windows_problem(path):
    """What keeps Windows from a file of that full path, as part of a sentence, or None."""
    path = pathlib.PureWindowsPath(path)
    if len(str(path)) > _MOST_ON_WINDOWS:
        return f"Windows takes paths of about {_MOST_ON_WINDOWS} characters here, and it has {len(str(path))}"
    for part in path.parts[1:]:
        if part not in (".", "..") and file_name(part) != part:
            return f"Windows takes no file that is called '{part}'"
    return None
