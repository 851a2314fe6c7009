# SPDX-License-Identifier: GPL-3.0-or-later
"""Marker sets that the artist saved, kept with Blender's presets: for names of markers, their places on the body."""

import pathlib

import bpy

from ... import ids, wording
from ...errors import MeanValueError, SceneError
from ...scene.core.file_names import file_name
from ..core import landmarks, marker_sets


def folder(create=False):
    """Where they are, or None if nothing was saved yet."""
    found = bpy.utils.user_resource('SCRIPTS', path=f"presets/{ids.MARKER_SETS_FOLDER}", create=create)
    return pathlib.Path(found) if found else None


def own_sets():
    """({name: marker set}, notes on files that cannot be read)."""
    sets, notes = {}, []
    where = folder()
    for path in sorted(where.glob("*.json")) if where else ():
        try:
            name, marker_set = marker_sets.load(path)
            sets[name] = marker_set
        except MeanValueError as error:
            notes.append(f"Marker set left out: {error}")
    return sets, notes


def recognised(capture, labels):
    """(landmark or None for each of the labels, words on what the names tell, notes). What the artist chose in the list
    comes before what the name tells. @throws SceneError if that is no landmark."""
    sets, notes = own_sets()
    recognition = marker_sets.recognise(labels, sets)
    own = [capture.pairs[label].landmark if label in capture.pairs else "" for label in labels]
    unknown = sorted({landmark for landmark in own if landmark and landmarks.place_of(landmark) is None})
    if unknown:
        raise SceneError(
            f"{wording.quoted(unknown)} {'is no landmark' if len(unknown) == 1 else 'are no landmarks'}. Choose from "
            "the list that opens in the field, or clear it"
        )
    places = tuple(mine or by_name for mine, by_name in zip(own, recognition.landmarks, strict=True))
    chosen = sum(map(bool, own))
    by_hand = f", {wording.counted(chosen, 'landmark')} chosen by hand" if chosen else ""
    return places, recognition.words.rstrip(".") + by_hand, notes


def save(name, capture):
    """Writes the landmarks of all markers as a set `name`. Returns (its path, count). @throws MeanValueError."""
    labels = [pair.name for pair in capture.pairs]
    places, _, _ = recognised(capture, labels)
    known = {label: place for label, place in zip(labels, places, strict=True) if place}
    if not known:
        raise SceneError("No marker has a landmark yet. Choose one for each marker of the list first")
    if not name.strip():
        raise SceneError("The marker set has no name. Fill it in")
    path = folder(create=True) / f"{file_name(bpy.path.clean_name(name))}.json"
    marker_sets.save(path, name, known)
    return path, len(known)


def candidates():
    """Names of all landmarks, with sides where a body has two."""
    for name, place in landmarks.PLACES.items():
        is_limb = any("*" in segment for segment in place.segments)
        yield from ([] if is_limb else [name])
        yield from (f"{name}.L", f"{name}.R")
