# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of how well the frames of a bake were solved, as SVG: any browser shows it."""

from xml.sax.saxutils import escape

import numpy as np

WIDTH, HEIGHT, MARGIN = 900, 160, 60
COLORS = {"energy": "#c2571a", "distance": "#2b6ca3"}


def svg(frames, title):
    """Text of the picture: energy, and distance from the targets. frames: of BakeReport.content(), one at least."""
    times = np.array([each["frame"] for each in frames], np.float64)
    values = {name: _column(frames, name) for name in COLORS}
    panels = (
        ("energy", values["energy"]),
        ("distance of the farthest handle from its target", values["distance"]),
    )
    height = MARGIN + len(panels) * (HEIGHT + MARGIN)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH + 2 * MARGIN}" height="{height}" '
        'font-family="sans-serif" font-size="12">',
        '<rect width="100%" height="100%" fill="white"/>',
        f'<text x="{MARGIN}" y="24" font-size="15">{escape(title)}</text>',
    ]
    for number, (name, curve) in enumerate(panels):
        parts += _panel(name, times, curve, MARGIN + number * (HEIGHT + MARGIN))
    return "\n".join([*parts, "</svg>", ""])


def _column(frames, name):
    numbers = [each.get(name) for each in frames]
    return np.array([np.nan if number is None else number for number in numbers], np.float64)


def _panel(name, times, values, top):
    """Lines of one curve with its axes. Values that are no numbers leave gaps."""
    known = np.isfinite(values)
    most = float(values[known].max(initial=0.0))
    first, last = float(times[0]), float(times[-1])
    across = MARGIN + WIDTH * (times - first) / max(last - first, 1.0)
    down = top + HEIGHT * (1.0 - np.where(known, values, 0.0) / (most or 1.0))
    yield f'<text x="{MARGIN}" y="{top - 6}">{escape(name)}, at most {most:.3g}</text>'
    yield (
        f'<path d="M{MARGIN} {top}V{top + HEIGHT}H{MARGIN + WIDTH}" fill="none" stroke="#888"/>'
        f'<text x="{MARGIN}" y="{top + HEIGHT + 16}">frame {first:g}</text>'
        f'<text x="{MARGIN + WIDTH}" y="{top + HEIGHT + 16}" text-anchor="end">{last:g}</text>'
    )
    color = COLORS[name.split()[0]]
    for run in np.split(np.flatnonzero(known), np.flatnonzero(np.diff(np.flatnonzero(known)) > 1) + 1):
        if len(run):
            points = " ".join(f"{across[row]:.1f},{down[row]:.1f}" for row in run)
            yield f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="1.5"/>'
