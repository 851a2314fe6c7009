# SPDX-License-Identifier: GPL-3.0-or-later
"""meanvalue.build_info()."""

import pathlib

import meanvalue


def test_the_module_tells_how_it_was_built():
    info = meanvalue.build_info()
    assert set(info) == {"compiler", "eigen", "instructions", "threads"}
    assert info["compiler"].split()[0] in {"GCC", "Clang", "MSVC"} and info["threads"] >= 1
    assert info["eigen"].count(".") == 2
    flags = pathlib.Path("/proc/cpuinfo")
    if flags.exists() and "\nflags" in flags.read_text():
        has_both = {"avx2", "fma"} <= set(flags.read_text().split("\nflags", 1)[1].split("\n", 1)[0].split())
        assert info["instructions"] == ("AVX2 and FMA" if has_both else "portable")
