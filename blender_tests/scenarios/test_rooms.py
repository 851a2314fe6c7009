# SPDX-License-Identifier: GPL-3.0-or-later
"""A feature is taken out with its folder and its one line of registration: the rest registers and works as before."""

import os
import pathlib
import subprocess
import zipfile

import bpy
import pytest
from support import installed

TESTS = pathlib.Path(__file__).resolve().parents[1]

#: Of each room what is quick and goes through most of it.
QUICK = {
    "posing": (
        "test_registration.py::test_off_and_on_again_leaves_one_of_everything",
        "test_grab.py::test_a_fresh_mesh_is_grabbed_and_its_surroundings_follow_less_and_less",
    ),
    "mixing": ("test_shape_mix.py::test_live_posing_and_mixing_take_turns",),
    "wrapping": ("test_wrap.py::test_the_other_shape_is_a_shape_key_in_the_mesh_s_own_space",),
    "capture": ("test_match_markers.py::test_at_rest_in_the_reference_frame_and_followed_in_others",),
    "baking": ("test_bake_keys.py::test_values_cross_fade_linearly",),
    "sliders": ("test_drive_keys.py::test_sliders_follow_within_their_ranges",),
}

#: The rooms that know another one go with it.
USERS = {"capture": ("sliders",), "baking": ("sliders",)}

pytestmark = pytest.mark.skipif(not bpy.app.binary_path, reason="the bpy module starts no Blender")


def without(rooms, target):
    """The add-on's zip without the folders of rooms and their lines."""
    removed = 0
    with zipfile.ZipFile(installed.ZIP) as whole, zipfile.ZipFile(target, "w") as rest:
        for entry in whole.infolist():
            content = whole.read(entry)
            if not rooms.isdisjoint(pathlib.PurePosixPath(entry.filename).parts[:-1]):
                continue
            if entry.filename.endswith("registration.py"):
                lines = content.decode().splitlines(keepends=True)
                kept = [line for line in lines if line.strip().strip('",') not in rooms]
                removed, content = len(lines) - len(kept), "".join(kept).encode()
            rest.writestr(entry, content)
    assert removed == len(rooms)
    return target


@pytest.mark.slow
@pytest.mark.parametrize("room", [room for room in QUICK if room != "posing"])
def test_the_others_work_without(room, tmp_path):
    rooms = {room, *USERS.get(room, ())}
    reduced = without(rooms, tmp_path / pathlib.Path(installed.ZIP).name)
    wanted = [f"{TESTS}/scenarios/{each}" for name, tests in QUICK.items() if name not in rooms for each in tests]
    folders = {name: tmp_path / name.lower() for name in ("SCRIPTS", "CONFIG", "RESOURCES", "EXTENSIONS")}
    for folder in folders.values():
        folder.mkdir()
    environment = {
        **os.environ,
        "MEANVALUE_ADDON_ZIP": str(reduced),
        **{f"BLENDER_USER_{name}": str(folder) for name, folder in folders.items()},
    }
    command = [bpy.app.binary_path, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1"]
    command += ["--python", str(TESTS / "run.py"), "--", "-q", "-rs", *wanted]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    assert " failed" not in done.stdout and "Traceback" not in done.stderr, done.stdout + done.stderr
    assert " passed" in done.stdout
