# SPDX-License-Identifier: GPL-3.0-or-later
"""The places on the body that names of markers, and the artist, tell."""

from ... import wording
from ...errors import SceneError
from ..core import landmarks, marker_sets


def recognised(capture, labels, is_skeleton):
    """({label: landmark or None}, the labels of other subjects than the person, words on what the names tell). What
    the artist chose in the list comes before what the name tells. @throws SceneError if that is no landmark."""
    recognition = marker_sets.recognise(labels, is_skeleton)
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
    others = frozenset(labels[number] for number in recognition.others if not places[number])
    words = f"{sum(map(bool, recognition.landmarks))} of {len(labels)} names are known{by_hand}"
    return dict(zip(labels, places, strict=True)), others, words


def candidates():
    """Names of all landmarks, with sides where a body has two."""
    for name, place in landmarks.PLACES.items():
        is_limb = any("*" in segment for segment in place.segments)
        yield from ([] if is_limb else [name])
        yield from (f"{name}.L", f"{name}.R")
