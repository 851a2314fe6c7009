# SPDX-License-Identifier: GPL-3.0-or-later
"""The farm's program, two clips for it, and what a single process bakes of them."""

import importlib.util
import pathlib

import bpy

from . import handles, installed, meshes
from .baking import animated_tube, bake, key_control, save

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "packaging" / "farm"
SCRIPT = FOLDER / "meanvalue_farm.py"
FRAMES = 60  # more than one run of the solver, so that runs fade into each other


def program(package=installed.PACKAGE):
    """The module, for the add-on of that name."""
    spec = importlib.util.spec_from_file_location("meanvalue_farm", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.addon = module.parts_of(package)
    return module


def run(*arguments):
    """The exit code of a command, in this Blender."""
    try:
        return program().main([str(argument) for argument in arguments])
    except SystemExit as error:  # as argparse ends
        return error.code


def two_clips(tmp_path):
    """A saved file with two animated tubes of their own animation."""
    animated_tube("First", FRAMES)
    second, control = handles.tube("Second", live=False)
    second.location.x = 4.0
    bpy.context.view_layer.update()
    key_control(control, FRAMES, reach=-1.0)
    bpy.context.scene.frame_set(1)
    meshes.activate(second)
    return save(tmp_path)


def baked_at_once(tmp_path, name):
    """The bytes of the point cache that the operator writes."""
    meshes.activate(bpy.data.objects[name])
    bake(path=str(tmp_path / "at_once" / f"{name}.pc2"))
    return (tmp_path / "at_once" / f"{name}.pc2").read_bytes()


def planned(tmp_path, *options):
    """OUT with the plan of the scene that is open, in chunks of 20 frames."""
    assert run("plan", "--out", tmp_path / "out", "--chunk", 20, *options) == 0
    return tmp_path / "out"
