# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of files that every system takes. A scene goes from one system to another, so the rules are the same on all."""

import re

#: With any ending Windows takes them for devices.
_DEVICE = re.compile(r"^(con|prn|aux|nul|com[0-9¹²³]|lpt[0-9¹²³])(?=\.|$)", re.IGNORECASE)
_REFUSED = re.compile(r'[<>:"/\\|?*\x00-\x1f]')


def file_name(name):
    """`name` of an object or a clip, without an ending, as that of a file or folder."""
    return _DEVICE.sub(r"\1_", _REFUSED.sub("_", name).rstrip(". ")) or "_"
