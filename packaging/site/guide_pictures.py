# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuts the pictures of the interface that the guide shows out of the screenshots of the interface tests.

Arguments: the folder of the screenshots, that of the pictures. `--scenarios` prints what makes the screenshots, for -k.
"""

import pathlib
import sys

#: Picture: scenario that takes it, screenshot, and what is cut out (left, upper, right, lower), in its pixels.
VIEW = (0, 30, 1036, 720)
SIDEBAR = (835, 88, 1028, 720)
PICTURES = {
    "grab": ("picture_of_the_guide", "grab_9_guide", (0, 56, 1036, 660)),
    "live_drag": ("overlay_on_views", "overlay_02_posed", VIEW),
    "region_overlay": ("overlay_on_views", "overlay_01_region", (280, 82, 1036, 720)),
    "wrap_pairs": ("pairs_are_clicked", "wrap_01_picked", VIEW),
    "markers_matched": ("import_match_and_pick", "capture_04_matched", VIEW),
    "panel_bake": ("guide_pictures-bake", "guide_bake", SIDEBAR),
    "panel_values": ("guide_pictures-values", "guide_values", SIDEBAR),
}
QUALITY = 80


def main(screenshots, pictures):
    from PIL import Image

    for name, (_scenario, screenshot, box) in PICTURES.items():
        picture = Image.open(screenshots / f"{screenshot}.png").convert("RGB").crop(box)
        picture.save(pictures / f"{name}.jpg", quality=QUALITY, optimize=True, progressive=True)


if __name__ == "__main__":
    if sys.argv[1:] == ["--scenarios"]:
        print(" or ".join(dict.fromkeys(scenario for scenario, _screenshot, _box in PICTURES.values())))
    else:
        main(*map(pathlib.Path, sys.argv[1:3]))
