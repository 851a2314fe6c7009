# SPDX-License-Identifier: GPL-3.0-or-later
"""Values over time beside the truth, as an SVG file. No bpy."""

import numpy as np

WIDTH, HEIGHT, GAP, COLUMNS = 240, 110, 26, 4
TRUTH, FOUND = ("#9aa7b5", 5), ("#d9480f", 1.8)


def write(path, names, truth, found):
    """truth, found: (f, s), 0 to 1, a panel for each of the s names."""
    rows = -(-len(names) // COLUMNS)
    size = COLUMNS * (WIDTH + GAP) + GAP, rows * (HEIGHT + GAP) + 2 * GAP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size[0]}" height="{size[1]}" font-family="sans-serif">',
        f'<rect width="{size[0]}" height="{size[1]}" fill="white"/>',
    ]
    for number, name in enumerate(names):
        left = GAP + number % COLUMNS * (WIDTH + GAP)
        top = GAP + number // COLUMNS * (HEIGHT + GAP)
        parts.append(f'<rect x="{left}" y="{top}" width="{WIDTH}" height="{HEIGHT}" fill="#f4f6f8"/>')
        parts.append(f'<text x="{left}" y="{top - 6}" font-size="13">{name}</text>')
        for values, style in ((truth, TRUTH), (found, FOUND)):
            parts.append(_line(values[:, number], left, top, *style))
    legend = f"values over {len(truth)} frames, from 0 to 1: truth (gray, wide) and found (orange)"
    parts.append(f'<text x="{GAP}" y="{size[1] - 14}" font-size="13">{legend}</text></svg>')
    path.write_text("\n".join(parts), encoding="utf-8")


def _line(values, left, top, colour, width):
    across = left + WIDTH * np.linspace(0.0, 1.0, len(values))
    points = " ".join(f"{x:.1f},{top + HEIGHT * (1.0 - y):.1f}" for x, y in zip(across, values, strict=True))
    return f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="{width}"/>'
