# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the pictures of docs/pictures, and says which command makes each of them.

    guide_pictures.py interface SCREENSHOTS PICTURES    cut out of what the interface tests left (./dev docs pictures)
    guide_pictures.py demos DEMOS PICTURES              made smaller of what demos left (./dev docs pictures demos)
    guide_pictures.py scenarios                         names, for -k, of what makes the screenshots
"""

import pathlib
import shutil
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
#: Picture: demo (`./dev demo NAME`, "" without a name) that makes it, its file in build/demo, and how wide it becomes.
DEMOS = {
    "octopus.jpg": ("", "octopus_before_after.png", 1400),
    "game_character.jpg": ("", "game_figure_before_after.png", 1200),
    "character.jpg": ("character", "character.png", 1000),
    "octopus_lift.webp": ("lift", "octopus_lift.webp", None),
    "corrective.jpg": ("rig", "rig_walker.png", 1500),
    "own_rig.jpg": ("example", "example_walker.png", 1200),
    "joints.jpg": ("joints", "joints.png", 1600),
    "mirror_seam.jpg": ("mirror", "mirror_seam.png", 1600),
    "morph_arms.jpg": ("morph", "morph_arms.png", 1600),
    "morph_creatures.jpg": ("morph", "morph_creatures.png", 1400),
    "morph_graft.jpg": ("morph", "morph_graft.png", 1200),
    "walk.jpg": ("walk", "walk_strip.png", 1600),
    "walk_short_legs.jpg": ("walk", "walk_short_legs_strip.png", 1600),
    "sit.jpg": ("walk", "sit_strip.png", 1600),
    "bones.jpg": ("bones", "bones.png", 1600),
    "face.jpg": ("face", "face_noisy.png", 1500),
    "keys_face.jpg": ("keys", "keys_face.png", 1400),
    "keys_shoulder.jpg": ("keys", "keys_shoulder.png", 1400),
    "face_values.svg": ("face", "face_noisy.svg", None),
}
#: Written by `./dev docs pictures`, by `./dev bench report`, and by hand.
OTHERS = {"house.svg", "speed.png", "quality.png", "ring.svg"}
QUALITY = 80


def cut(screenshots, pictures):
    """Of the interface."""
    for name, (_scenario, screenshot, box) in PICTURES.items():
        save(opened(screenshots / f"{screenshot}.png").crop(box), pictures / f"{name}.jpg")


def take(demos, pictures):
    """Of those demos that were run; tells the others."""
    for name, (demo, file, width) in DEMOS.items():
        source = demos / file
        if not source.exists():
            print(f"{name}: first run ./dev demo {demo}".rstrip())
        elif width is None:
            shutil.copyfile(source, pictures / name)
        else:
            picture = opened(source)
            save(picture.resize((width, round(width * picture.height / picture.width))), pictures / name)


def opened(path):
    from PIL import Image

    return Image.open(path).convert("RGB")


def save(picture, path):
    picture.save(path, quality=QUALITY, optimize=True, progressive=True)


if __name__ == "__main__":
    if sys.argv[1:] == ["scenarios"]:
        print(" or ".join(dict.fromkeys(scenario for scenario, _screenshot, _box in PICTURES.values())))
    else:
        {"interface": cut, "demos": take}[sys.argv[1]](*map(pathlib.Path, sys.argv[2:4]))
