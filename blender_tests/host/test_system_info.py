# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of Copy System Info."""

import pathlib

import meanvalue
import pytest

from addon.posing.core import system_info


def test_lines_under_their_headings_and_nothing_empty():
    sections = (("", (("Blender", "3.4.1"),)), ("Object", (("Pins", 0), ("Live", None), ("Said", ""))), ("None", ()))
    assert system_info.text(sections) == "Blender: 3.4.1\n\nObject\nPins: 0\n\nNone\n"


@pytest.mark.parametrize(
    "message, clean",
    [
        ("Handle 'Secret hand' carries 4 vertices", "Handle '...' carries 4 vertices"),
        ("'Joe's mesh' is not the mesh's own", "'...' is not the mesh's own"),
        ("A fifth of the mesh's size, not the handle's", "A fifth of the mesh's size, not the handle's"),
        ("Cannot write /home/joe/secret.pc2: the disk is full", "Cannot write <path> the disk is full"),
        (r"Baked to C:\Users\joe\secret.pc2 and //secret.pc2", "Baked to <path> and <path>"),
        ("Secret walk has 3 markers; Secretly", "... has 3 markers; Secretly"),
        ("Secret walk of joe: 12 samples", "... of ...: 12 samples"),
        ("a 3 of 3.5", "a 3 of 3.5"),
    ],
)
def test_names_and_paths_are_left_out(message, clean):
    private = ["Secret walk", "Secret", "joe", "a", "3", "3.5", "."]
    assert system_info.without_names(message, private) == clean


def test_the_processor_is_named(tmp_path):
    listing = tmp_path / "cpuinfo"
    listing.write_text("processor : 0\nmodel name\t: Some  CPU 3000 @ 2 GHz\nmodel name : another\n")
    assert system_info.processor(listing) == "Some CPU 3000 @ 2 GHz"
    assert system_info.processor(tmp_path / "missing")


def test_the_module_tells_how_it_was_built():
    info = meanvalue.build_info()
    assert set(info) == {"compiler", "eigen", "instructions", "threads"}
    assert info["compiler"].split()[0] in {"GCC", "Clang", "MSVC"} and info["threads"] >= 1
    assert info["eigen"].count(".") == 2
    flags = pathlib.Path("/proc/cpuinfo")
    if flags.exists() and "\nflags" in flags.read_text():
        has_both = {"avx2", "fma"} <= set(flags.read_text().split("\nflags", 1)[1].split("\n", 1)[0].split())
        assert info["instructions"] == ("AVX2 and FMA" if has_both else "portable")
