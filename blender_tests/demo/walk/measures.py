# SPDX-License-Identifier: GPL-3.0-or-later
"""How good a bake is, in figures."""

import numpy as np

from addon.scene.core.motion import fit_rotations


def rms(shapes, truth):
    """(f,): root mean square distance of the vertices (f, n, 3) from where they should be."""
    return np.sqrt(((shapes - truth) ** 2).sum(2).mean(1))


def laid_on(shapes, truth):
    """The shapes (f, n, 3), each moved and turned as a whole to where it should be."""
    pairs = zip(shapes.astype(float), truth, strict=True)
    return np.array([(shape - shape.mean(0)) @ fit_rotations(shape, goal).T + goal.mean(0) for shape, goal in pairs])


def roughness(paths):
    """(f - 2, n): lengths of the second differences of paths (f, n, 3): how suddenly they turn or change speed."""
    return np.linalg.norm(np.diff(paths, 2, axis=0), axis=2)


def slide(shapes, planted):
    """The farthest that a vertex of a standing sole goes along the ground from where it stood first."""
    farthest = 0.0
    for begin, end, sole in planted:
        if end - begin > 1:
            stance = shapes[begin:end, sole, :2]
            farthest = max(farthest, float(np.linalg.norm(stance - stance[0], axis=2).max()))
    return farthest


def hover(shapes, rest, planted):
    """The farthest that a vertex of a standing sole is above or below where it rests, (n, 3)."""
    return max(float(np.abs(shapes[begin:end, sole, 2] - rest[sole, 2]).max()) for begin, end, sole in planted)


def misses(carried):
    """(f, m): how far each anchor is from its target; NaN where it was free."""
    return np.linalg.norm(carried.shapes[:, carried.anchors] - carried.targets, axis=2)


def rows(subject, carried):
    """[(what, figure in words)] for the report."""
    miss, height = misses(carried), subject.height
    result = [
        ("vertices, frames", f"{len(subject.vertices):,}, {len(carried.shapes):,}"),
        ("markers", f"{len(carried.anchors)}, {np.isnan(carried.targets[..., 0]).mean():.1%} of the samples free"),
        ("marker to skin, reference", f"{mm(carried.matched.mean())} on average, at most {mm(carried.matched.max())}"),
        ("anchor to its target", f"{mm(np.nanmean(miss))} on average, at most {mm(np.nanmax(miss))}"),
    ]
    if subject.truth is not None:
        for what, shapes in (
            ("off the skinned figure", carried.shapes),
            ("  by its shape alone", laid_on(carried.shapes, subject.truth)),
        ):
            off = rms(shapes, subject.truth)
            whole = np.sqrt((off**2).mean())
            result.append(
                (what, f"rms {share(whole, height)}, worst frame {off.argmax() + 1}: {share(off.max(), height)}")
            )
    words = f"vertices at most {mm(roughness(carried.shapes).max())}"
    result.append(("second differences", f"{words}, targets {mm(np.nanmax(roughness(carried.targets)))}"))
    result.append(("slide of standing soles", share(slide(carried.shapes, subject.planted), height)))
    result.append(("  off the floor", mm(hover(carried.shapes, subject.vertices, subject.planted))))
    return result


def share(metres, height):
    return f"{mm(metres)} ({metres / height:.2%} of the height)"


def mm(metres):
    return f"{1000.0 * metres:.1f} mm"
