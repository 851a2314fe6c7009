# SPDX-License-Identifier: GPL-3.0-or-later
"""How shape keys are shown, and the way back."""

#: What making and muting the result changes; the limits of the slider before the value, which they cut off.
_STATE = ("mute", "vertex_group", "slider_min", "slider_max", "value")


def read(obj):
    """{name of a key: how it is shown}, for bring_back()."""
    keys = obj.data.shape_keys
    return {
        key.name: (key.relative_key.name, *(getattr(key, name) for name in _STATE))
        for key in (keys.key_blocks if keys else ())
    }


def bring_back(obj, states):
    """Has the keys that are still there be shown as when read() was called."""
    blocks = obj.data.shape_keys.key_blocks if obj.data.shape_keys else {}
    for name, (relative_to, *values) in states.items():
        if name not in blocks:
            continue
        if relative_to in blocks:
            blocks[name].relative_key = blocks[relative_to]
        for attribute, value in zip(_STATE, values, strict=True):
            setattr(blocks[name], attribute, value)
