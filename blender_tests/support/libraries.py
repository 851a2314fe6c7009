# SPDX-License-Identifier: GPL-3.0-or-later
"""Datablocks of other .blend files, appended or linked."""

import bpy


def load(path, kind, names=(), link=False):
    """Those of a kind, 'objects' or so, by their names or all; objects are in the scene then."""
    with bpy.data.libraries.load(str(path), link=link) as (there, wanted):
        setattr(wanted, kind, list(names or getattr(there, kind)))
    found = getattr(wanted, kind)
    for each in found if kind == "objects" else ():
        bpy.context.collection.objects.link(each)
    return found


def linked(folder, datablock, kind):
    """A datablock of this file as it is linked from another, which is written for that."""
    path = folder / "library.blend"
    bpy.data.libraries.write(str(path), {datablock}, fake_user=True)
    return load(path, kind, [datablock.name], link=True)[0]
