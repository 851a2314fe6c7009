# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's words in other languages, for Blender's own translation: one file of gettext's (.po) for each.

What Blender's own catalogue knows under the same context comes before what is here.
"""

import json
import pathlib

import bpy

from .. import compat
from ..core import language

FOLDER = pathlib.Path(__file__).resolve().parent

#: Context of a message that has none.
DEFAULT = "*"


def register():
    bpy.app.translations.unregister(__package__)  # of a registering that was broken off; does nothing else
    bpy.app.translations.register(__package__, {compat.locale(path.stem): read(path) for path in files()})
    language.use(bpy.app.translations.pgettext_iface)


def unregister():
    language.use(str)
    bpy.app.translations.unregister(__package__)


def files():
    return sorted(FOLDER.glob("*.po"))


def read(path):
    """{(context, English): translation} of a .po file."""
    messages, entry, field = {}, {}, None
    for line in [*path.read_text(encoding="utf-8").splitlines(), ""]:
        if line.startswith("#"):
            continue
        if not line:
            if entry.get("msgid") and entry.get("msgstr"):
                messages[entry.get("msgctxt", DEFAULT), entry["msgid"]] = entry["msgstr"]
            entry = {}
            continue
        if not line.startswith('"'):
            field, _, line = line.partition(" ")
        entry[field] = entry.get(field, "") + json.loads(line)
    return messages
