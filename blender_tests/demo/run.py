# SPDX-License-Identifier: GPL-3.0-or-later
"""Entry point of `./dev demo`, run by Blender: blender -b --factory-startup --python run.py -- [arguments].

MEANVALUE_ADDON_ZIP in the environment is the add-on to install.
"""

import argparse
import os
import sys
import time
import traceback
from contextlib import contextmanager
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import demo.bones
import demo.character
import demo.joints
import demo.keys
import demo.lift
import demo.mirror
from demo import DemoError, arguments, built_in, common_options, game_figure, pose, ready, report, stage, user_file
from demo.example import run as example
from demo.face import run as face
from demo.morph import run as morph
from demo.photograph import photograph
from demo.rig import run as rig
from demo.walk import run as walk

#: Demos with a command line of their own.
SPECIAL = {"walk": walk, "morph": morph, "rig": rig, "example": example, "face": face, "keys": demo.keys}
SPECIAL |= {"joints": demo.joints, "lift": demo.lift, "mirror": demo.mirror, "character": demo.character}
SPECIAL |= {"bones": demo.bones}


def main(argv):
    """Runs the demo; returns the exit status."""
    special = SPECIAL.get(argv[0]) if argv else None
    if special:
        options = common_options.of_demo(argv[0], special.DESCRIPTION, argv[1:], **special.OPTIONS)
    else:
        options = arguments.parse(argv)
    try:
        make_folder(options.output)
        pose.install_addon(os.environ.get("MEANVALUE_ADDON_ZIP"))
        if special:
            about, blocks, name = special.ABOUT, special.blocks(options, empty_scene), f"{argv[0]}_report.txt"
        else:
            blocks = [run_subject(make, options) for make in makers(options)]
            about, name = ("meshes posed by their anchors",), "report.txt"
    except DemoError as error:
        print(f"./dev demo: {error}", file=sys.stderr)
        return 1
    text = report.text(about, bpy.app.version_string, addon_version(), blocks)
    (options.output / name).write_text(text, encoding="utf-8")
    print("\n" + text)
    print(f"Written to {options.output}: {name} and the files above")
    return 0


def make_folder(path):
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DemoError(f"the folder {path} cannot be made ({error.strerror}); name another one by --output") from error


def makers(options):
    """Functions that each load one subject into an empty scene."""
    if options.file is not None:
        return [lambda: user_file.user_subject(options)]
    made = {"octopus": built_in.octopus, "game_figure": lambda: game_character(options)}
    return [make for name, make in made.items() if options.only in (None, name)]


def game_character(options):
    """Written as glTF, and read as a file of the user's is."""
    path = options.output / "game_figure.glb"
    game_figure.write(path)
    empty_scene()
    return user_file.user_subject(argparse.Namespace(**{**vars(options), "file": path}))


def run_subject(make, options):
    """Models or loads one subject, poses it, photographs and saves it; returns its lines of the report."""
    seconds = {}
    with timed(seconds, "load" if options.file else "model"):
        empty_scene()
        subject = make()
    print(f"{subject.title}: posing ...", flush=True)
    seconds |= pose.pose_by_operators(subject)
    if subject.companions:
        user_file.hide_what_would_stay_behind(subject)
    print(f"{subject.title}: rendering ...", flush=True)
    view = subject.view
    picture = stage.Picture(view.width, view.height, options.samples, options.engine)
    with timed(seconds, "render"):
        files = photograph(subject, picture, options.output)
    if subject.grab is not None:
        subject.obj.meanvalue.live = True
    elif not options.file:
        ready.to_be_tried(subject)
    with timed(seconds, "write"):
        files.append(save(options.output / f"{subject.file_stem}.blend"))
    rows = [
        ("vertices, faces", f"{len(subject.obj.data.vertices):,}, {len(subject.obj.data.polygons):,}"),
        ("seconds", ", ".join(f"{name} {value:.2f}" for name, value in seconds.items())),
        ("files", ", ".join(files)),
    ]
    return report.block(subject.title, rows)


@contextmanager
def timed(seconds, stage_name):
    """Stores the seconds its block took under `stage_name`."""
    start = time.perf_counter()
    yield
    seconds[stage_name] = time.perf_counter() - start


def empty_scene():
    """A new file without objects; the enabled add-ons stay."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def save(path):
    """Writes the .blend with the result shown; returns its name."""
    bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), check_existing=False)
    return path.name


def addon_version():
    """The installed add-on's version as text."""
    return ".".join(map(str, sys.modules[pose.ADDON].bl_info["version"]))


if __name__ == "__main__":
    try:
        status = main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])
    except Exception:  # Blender would go on, and end with its own status
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    if status:
        sys.exit(status)
