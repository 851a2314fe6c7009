# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads C3D files: all three number formats, whole numbers and floats. Why not a library: docs/decisions/0014."""

from __future__ import annotations

import numpy as np

from . import model_outputs, units
from .c3d_layout import find_layout, first_frame, frame_rate, open_sections
from .recording import Recording
from .take import Take

#: Makers whose files have Y up where they do not say it.
Y_UP_MAKERS = ("motion analysis", "optitrack", "naturalpoint")
RATE_WITHOUT = 100.0


def read(data: bytes, file: str, up_axis: str | None = None, unit: float | None = None) -> Take:
    """The physical markers of a C3D file of that content; `file` is its name. Raises MotionFileError."""
    header, parameters, numbers = open_sections(data, file)
    layout, note = find_layout(header, parameters, numbers, len(data), file)
    labels = _labels(parameters, layout.points)
    kinds = model_outputs.in_c3d(parameters, labels)
    notes = [note] if note else []
    chosen = np.flatnonzero([kind is None for kind in kinds])
    positions, computed = _samples(data, layout, chosen)
    axes = model_outputs.segment_axes([labels[point] for point in chosen], positions)
    for point in chosen[axes]:
        kinds[point] = "segment axes"
    labels_left, positions, computed = _without(axes, [labels[point] for point in chosen], positions, computed)
    model_outputs.require_markers(labels_left, kinds, file)
    _note_computed(labels_left, computed, notes)
    rate = frame_rate(header, parameters)
    if rate is None:
        notes.append(f"The file names no usable rate: {RATE_WITHOUT:g} frames a second are assumed")
    return Recording(
        file=file,
        rate_hz=rate or RATE_WITHOUT,
        first_frame=first_frame(header, parameters),
        labels=labels_left,
        positions=positions,
        unit=_unit(parameters, notes),
        up_axis=_screen_up(parameters),
        usual_up=_usual_up(parameters),
        left_out=model_outputs.by_kind(labels, kinds),
        notes=notes,
    ).take(up_axis, unit)


def _labels(parameters, points):
    """One for each point: LABELS, LABELS2, ... one after the other (each holds 255), empty where there is none."""
    labels = []
    for name in model_outputs.numbered(parameters, "LABELS"):
        labels += parameters.strings("POINT", name)
    labels = labels[:points]
    return labels + [""] * (points - len(labels))


def _samples(data, layout, chosen):
    """(f, m, 3) float64 positions of the `chosen` points, NaN where they are invalid; (m,) bool: none was measured.

    The fourth word of a sample is -1 where it is invalid; else its low byte is the residual and its high byte has the
    cameras: both 0 where the point was computed or filtered.
    """
    words = layout.frame_bytes // layout.word
    count = layout.frames * words
    decode = layout.numbers.float32 if layout.is_float else layout.numbers.int16
    frames = decode(data, layout.start, count).reshape(layout.frames, words)[:, : 4 * layout.points]
    frames = frames.reshape(layout.frames, layout.points, 4)
    if len(chosen) < layout.points:
        frames = frames[:, chosen]
    with np.errstate(all="ignore"):  # damaged floats
        positions = frames[..., :3].astype(np.float64)
        if not layout.is_float:
            positions *= layout.scale
        fourth = frames[..., 3]
        valid = fourth >= 0  # False for NaN too
        computed = valid.any(axis=0) & ~(fourth > 0).any(axis=0)
    positions[~valid] = np.nan
    return positions, computed


def _without(left_out, labels, positions, computed):
    if not left_out.any():
        return labels, positions, computed
    keep = ~left_out
    return [label for label, kept in zip(labels, keep, strict=True) if kept], positions[:, keep], computed[keep]


def _note_computed(labels, computed, notes):
    """Where the file has residuals at all, points that never have one were computed, not measured."""
    if computed.any() and not computed.all():
        names = [label or "without name" for label, is_computed in zip(labels, computed, strict=True) if is_computed]
        shown = ", ".join(names[:5]) + (", ..." if len(names) > 5 else "")
        notes.append(f"{len(names)} points have no residual in any frame ({shown}): they were computed, or filtered")


def _unit(parameters, notes):
    name = parameters.string("POINT", "UNITS")
    metres = units.metres_in(name) if name else None
    if name and metres is None:
        notes.append(f"The file's unit '{name}' is not known")
    return metres


def _screen_up(parameters):
    """The axis that is drawn upwards on the screen of the capture system, where the file names two axes that differ."""
    across = parameters.string("POINT", "X_SCREEN").upper().lstrip("+")
    up = parameters.string("POINT", "Y_SCREEN").upper().lstrip("+")
    if up not in units.UP_AXES or across not in units.UP_AXES or up[-1] == across[-1]:
        return None
    return up


def _usual_up(parameters):
    maker = f"{parameters.string('MANUFACTURER', 'COMPANY')} {parameters.string('MANUFACTURER', 'SOFTWARE')}".lower()
    for name in Y_UP_MAKERS:
        if name in maker:
            return "Y", "as files of this maker have it"
    return "Z", "as most C3D files have it"
