# SPDX-License-Identifier: GPL-3.0-or-later
"""Which landmark each label of a marker set stands for."""

import re
from dataclasses import dataclass, field


@dataclass(frozen=True)
class MarkerSet:
    """Labels of a marker set and the landmark of each; other ways to write a label in `aliases` (alias -> label)."""

    name: str
    landmarks: dict
    aliases: dict = field(default_factory=dict)

    def landmark_of(self, label):
        """The landmark of a label or an alias, however it is spelled ("Subject:LASI", "r_knee"); or None."""
        return self._by_key().get(key_of(label))

    def _by_key(self):
        keys = {key_of(label): landmark for label, landmark in self.landmarks.items()}
        return {**{key_of(alias): self.landmarks[label] for alias, label in self.aliases.items()}, **keys}


def key_of(label):
    """A label without what laboratories write differently: prefixes up to ":", case, and what separates words."""
    return re.sub(r"[\s._\-]+", "", label.rsplit(":", 1)[-1]).casefold()
