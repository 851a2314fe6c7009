# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage to the bytes of files, by random numbers of a known seed."""

ODD_BYTES = (0, 1, 2, 32, 48, 57, 127, 128, 255)
ODD_WORDS = (b"\xff" * 4, b"\0" * 4, b"\x7f\x80\0\0", b"\0\0\x80\x7f", b"1e99", b"-1", b"nan", b"{}")


def mutated(content, random_numbers):
    """A copy with up to sixteen bytes or stretches replaced, dropped or doubled, mostly near the beginning; or cut."""
    result = bytearray(content)
    for _ in range(random_numbers.choice((1, 1, 2, 4, 16))):
        end = len(result) if random_numbers.random() < 0.3 else min(len(result), 3000)
        if end < 20:
            break
        place = random_numbers.randrange(end)
        act = random_numbers.random()
        if act < 0.7:
            result[place] = random_numbers.choice((*ODD_BYTES, random_numbers.randrange(256)))
        elif act < 0.8:
            del result[place : place + random_numbers.choice((1, 2, 7, 512))]
        elif act < 0.9:
            result[place:place] = result[place : place + random_numbers.choice((1, 2, 40, 512))]
        else:
            result[place : place + 4] = random_numbers.choice(ODD_WORDS)
    end = random_numbers.randrange(max(1, len(result))) if random_numbers.random() < 0.1 else len(result)
    return bytes(result[:end])
