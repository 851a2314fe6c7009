# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts broken to lines, in scripts with spaces between words and in those without."""

import re
import textwrap
import unicodedata

#: Chinese, Japanese and Korean, beside which a line may be broken, and what may not begin a line after them.
_WIDE = r"[\u1100-\u115f\u2e80-\u2fff\u3003-\u3007\u3012-\ua4cf\uac00-\ud7a3\uf900-\ufaff\uff10-\uff19\uff21-\uff5a]"
_CLOSING = r"[\u3001\u3002\u3009\u300b\u300d\u300f\u3011\u30fc\uff01\uff09\uff0c\uff0e\uff1a\uff1b\uff1f,.:;?!)]"
#: What may not end a line.
_OPENING = r"[\u3008\u300a\u300c\u300e\u3010\uff08]"
_PIECES = re.compile(rf"\s+|{_OPENING}*{_WIDE}{_CLOSING}*|(?:(?!{_OPENING}*{_WIDE})\S)+")


def wrap(text, width):
    """Lines of `text`, each no wider than `width` average letters, as textwrap.wrap(); wide letters count twice."""
    if re.search(_WIDE, text) is None:
        return textwrap.wrap(text, width)
    lines, line = [], ""
    for piece in _PIECES.findall(" ".join(text.split())):
        if line and columns(line + piece.rstrip()) > width:
            lines.append(line.rstrip())
            line = piece.lstrip()
        else:
            line += piece
    return [*lines, line.rstrip()] if line.strip() else lines


def columns(text):
    return sum(2 if is_wide(letter) else 1 for letter in text)


def is_wide(letter):
    """Whether it takes the room of two; "" does not."""
    return letter != "" and unicodedata.east_asian_width(letter) in "WF"
