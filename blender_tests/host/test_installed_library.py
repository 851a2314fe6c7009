# SPDX-License-Identifier: GPL-3.0-or-later
"""The C++ library as another project gets it, installed or as a part of it; its examples, and those of Python."""

import os
import pathlib
import shutil
import subprocess
import sys

import meanvalue
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILT = ROOT / "build" / "native"
EXAMPLES = ROOT / "native" / "examples"
PROGRAMS = sorted(path.stem for path in EXAMPLES.glob("*.cpp"))


def run(*command, **environment):
    command, environment = [str(part) for part in command], {**os.environ, **environment}
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_examples_of_both_languages_say_the_same(tmp_path):
    if not (BUILT / "cmake_install.cmake").exists() or shutil.which("cmake") is None:
        pytest.skip("needs CMake and the library in build/native (./dev build)")
    prefix, build = tmp_path / "prefix", tmp_path / "examples"
    run("cmake", "--install", BUILT, "--prefix", prefix)
    assert not list(prefix.rglob("*pybind11*")) and not list(prefix.rglob("meanvalue.*.so"))
    # The linker would keep the program's own, with its allocator.
    shared = run("nm", "--demangle", "--defined-only", next(prefix.rglob("libmeanvalue*"))).splitlines()
    assert not [line for line in shared if " W " in line and "Eigen::PlainObjectBase" in line]
    public = {path.relative_to(ROOT / "native" / "include") for path in (ROOT / "native" / "include").rglob("*.h")}
    assert {path.relative_to(prefix / "include") for path in prefix.rglob("*.h")} == public
    expected = [run(sys.executable, EXAMPLES / f"{name}.py") for name in PROGRAMS]
    assert len(expected) == 6 and "" not in expected
    # A program may be compiled for other instructions than the library: Eigen takes another allocator then.
    for each in ("", "-march=native"):
        options = ("-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_FLAGS={each}")
        run("cmake", "-S", EXAMPLES, "-B", build, *options)
        run("cmake", "--build", build)
        assert [run(build / name) for name in PROGRAMS] == expected
    assert all(len(path.read_text().splitlines()) <= 40 for path in EXAMPLES.iterdir() if path.is_file())
    inside = ("-B", tmp_path / "inside", f"-DMEANVALUE_SOURCE={ROOT}", "-DBUILD_SHARED_LIBS=ON")
    made = run("cmake", "-S", EXAMPLES, "-G", "Ninja", *inside)
    assert "pybind11" not in made and "GTest" not in made


def test_the_module_tells_how_it_was_built():
    info = meanvalue.build_info()
    assert set(info) == {"compiler", "eigen", "instructions", "threads"}
    assert info["compiler"].split()[0] in {"GCC", "Clang", "MSVC"} and info["threads"] >= 1
    assert info["eigen"].count(".") == 2
    flags = pathlib.Path("/proc/cpuinfo")
    if flags.exists() and "\nflags" in flags.read_text():
        has_both = {"avx2", "fma"} <= set(flags.read_text().split("\nflags", 1)[1].split("\n", 1)[0].split())
        assert info["instructions"] == ("AVX2 and FMA" if has_both else "portable")
