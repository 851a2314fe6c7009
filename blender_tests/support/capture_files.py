# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes small C3D, TRC and BVH files: motion capture for tests that must not need files of others."""

import numpy as np

BLOCK = 512
PROCESSORS = {"PC": 84, "DEC": 85, "SGI": 86}


def c3d(labels, positions, *, rate=100.0, unit="mm", screen=("+X", "+Z"), processor="PC", scale=-0.1, first_frame=1,
        residuals=1.0, analog=0, point=None, groups=None, header=None):  # fmt: skip
    """The bytes of a C3D file.

    `positions` (f, m, 3) in units of the file; NaN becomes an invalid sample (residual -1 and zeros). `scale` negative:
    floats, positive: whole numbers of that size. `residuals`: what measured samples have, a number or (f, m), in units
    of the file; 0: computed. `analog`: words of other data in each frame. `point`: parameters of POINT to add, to
    replace, or with None to leave out. `groups`: further groups {name: {parameter: value}}. `header`: words to write
    instead, by name.
    """
    positions = np.asarray(positions, np.float64)
    frames, points, _ = positions.shape
    values = {
        "USED": points,
        "FRAMES": min(frames, 65535),
        "SCALE": float(scale),
        "RATE": float(rate),
        "DATA_START": 0,
        "UNITS": unit,
        "X_SCREEN": screen[0] if screen else None,
        "Y_SCREEN": screen[1] if screen else None,
    }
    for part in range(-(-len(labels) // 255)):
        values[f"LABELS{part + 1}" if part else "LABELS"] = list(labels[255 * part : 255 * (part + 1)])
    values.update(point or {})
    if analog:
        groups = {"ANALOG": {"USED": analog, "RATE": float(rate)}, **(groups or {})}
    section = _parameter_section({"POINT": values, **(groups or {})}, processor)
    data_start = 2 + len(section) // BLOCK
    if values["DATA_START"] == 0:
        values["DATA_START"] = data_start
        section = _parameter_section({"POINT": values, **(groups or {})}, processor)
    samples = _samples(positions, scale, residuals, analog, processor)
    head = _header(points, analog, first_frame, frames, scale, data_start, rate, processor, header or {})
    return head + section + _padded(samples)


def _header(points, analog, first, frames, scale, data_start, rate, processor, changes):
    words = {
        "points": points,
        "analog": analog,
        "first": first,
        "last": min(first + frames - 1, 65535),
        "gap": 10,
        "scale": scale,
        "data_start": data_start,
        "samples": 1 if analog else 0,
        "rate": rate,
    }
    words.update(changes)
    raw = bytes((2, 0x50))
    for name, value in words.items():
        raw += _float(value, processor) if name in ("scale", "rate") else _words([value], processor)
    return raw.ljust(BLOCK, b"\0")


def _samples(positions, scale, residuals, analog, processor):
    frames, points, _ = positions.shape
    fourth = np.broadcast_to(np.round(np.asarray(residuals) / abs(scale)), (frames, points)).copy()
    fourth[fourth > 0] += 256 * 3  # two cameras
    missing = np.isnan(positions).any(axis=2)
    words = np.zeros((frames, points, 4))
    words[..., :3] = np.where(missing[..., None], 0.0, positions)
    words[..., 3] = np.where(missing, -1, fourth)
    if scale > 0.0:
        words[..., :3] = np.round(words[..., :3] / scale)
    words = np.concatenate([words.reshape(frames, 4 * points), np.full((frames, analog), 7.0)], axis=1)
    return _float(words, processor) if scale < 0.0 else _words(words, processor)


def _words(values, processor):
    return (np.asarray(values).astype(np.int64) & 0xFFFF).astype(">u2" if processor == "SGI" else "<u2").tobytes()


def _float(values, processor):
    values = np.atleast_1d(np.asarray(values, np.float32))
    if processor == "DEC":
        return (values * np.float32(4.0)).astype("<f4").view("<u2").reshape(-1, 2)[:, ::-1].tobytes()
    return values.astype(">f4" if processor == "SGI" else "<f4").tobytes()


def _parameter_section(groups, processor):
    raw = b""
    for number, (group, values) in enumerate(groups.items(), 1):
        raw += _entry(group, -number, b"\0", processor)
        for name, value in values.items():
            if value is not None:
                raw += _entry(name, number, _value(value, processor) + b"\0", processor)
    raw += b"\0\0"
    blocks = -(-(len(raw) + 4) // BLOCK)
    return (bytes((1, 0x50, min(blocks, 255), PROCESSORS[processor])) + raw).ljust(blocks * BLOCK, b"\0")


def _entry(name, group, content, processor):
    return bytes((len(name), group & 0xFF)) + name.encode() + _words([len(content) + 2], processor) + content


def _value(value, processor):
    """Type, dimensions and values of one parameter."""
    if isinstance(value, str):
        return bytes((0xFF, 1, len(value.encode()))) + value.encode()
    if isinstance(value, (list, tuple)) and all(isinstance(one, str) for one in value):
        texts = [one.encode() for one in value]
        width = max((len(text) for text in texts), default=0)
        return bytes((0xFF, 2, width, len(texts))) + b"".join(text.ljust(width) for text in texts)
    if isinstance(value, (list, tuple)):
        return bytes((2, 1, len(value))) + _words(value, processor)
    if isinstance(value, float):
        return bytes((4, 0)) + _float(value, processor)
    return bytes((2, 0)) + _words([value], processor)


def _padded(raw):
    return raw.ljust(-(-len(raw) // BLOCK) * BLOCK, b"\0")


def trc(labels, positions, *, rate=100.0, unit="mm", first_frame=1, decimals=5, digits=None, keys=None,
        begin=0.0):  # fmt: skip
    """The bytes of a TRC file; `positions` as for c3d(), NaN becomes blank cells; `digits`: significant ones, in
    place of `decimals`; `keys`: header values to replace; `begin`: seconds of the first frame."""
    positions = np.asarray(positions, np.float64)
    header = {
        "DataRate": f"{rate:g}",
        "CameraRate": f"{rate:g}",
        "NumFrames": len(positions),
        "NumMarkers": len(labels),
        "Units": unit,
        "OrigDataRate": f"{rate:g}",
        "OrigDataStartFrame": first_frame,
        "OrigNumFrames": len(positions),
    }
    header.update(keys or {})
    lines = ["PathFileType\t4\t(X/Y/Z)\ttake.trc", "\t".join(header), "\t".join(map(str, header.values()))]
    lines.append("Frame#\tTime\t" + "".join(f"{label}\t\t\t" for label in labels))
    lines.append("\t\t" + "".join(f"X{k}\tY{k}\tZ{k}\t" for k in range(1, len(labels) + 1)))
    lines.append("")
    form = f".{decimals}f" if digits is None else f".{digits}g"
    for number, frame in enumerate(positions):
        cells = ["" if np.isnan(value) else format(value, form) for value in frame.ravel()]
        lines.append("\t".join([str(first_frame + number), f"{begin + number / rate:.5f}", *cells]))
    return ("\n".join(lines) + "\n").encode()


def bvh(joints, motion, *, frame_time="0.0083333"):
    """The bytes of a BVH file.

    `joints`: nested (name, offset (3), channel names, children), of an end site (None, offset, (), ()). `motion`:
    (f, c).
    """
    lines = ["HIERARCHY"]
    _write_joint(lines, joints, "ROOT", "")
    lines += ["MOTION", f"Frames: {len(motion)}", f"Frame Time: {frame_time}"]
    lines += [" ".join(f"{value:.6f}" for value in row) for row in motion]
    return ("\n".join(lines) + "\n").encode()


def _write_joint(lines, joint, kind, indent):
    name, offset, channels, children = joint
    lines.append(f"{indent}End Site" if name is None else f"{indent}{kind} {name}")
    lines.append(f"{indent}{{")
    lines.append(f"{indent}\tOFFSET " + " ".join(f"{value:.6f}" for value in offset))
    if name is not None:
        lines.append(f"{indent}\tCHANNELS {len(channels)} {' '.join(channels)}")
    for child in children:
        _write_joint(lines, child, "JOINT", indent + "\t")
    lines.append(f"{indent}}}")


def has_note(take, *words):
    """Whether one of the notes of a Take has all these words."""
    return any(all(word in note for word in words) for note in take.notes)
