# SPDX-License-Identifier: GPL-3.0-or-later
"""The C++ library as another project gets it: installed, found, linked, run."""

import pathlib
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILT = ROOT / "build" / "native"


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_the_example_builds_against_the_installed_library(tmp_path):
    if not (BUILT / "cmake_install.cmake").exists() or shutil.which("cmake") is None:
        pytest.skip("needs CMake and the library in build/native (./dev build)")
    prefix, build = tmp_path / "prefix", tmp_path / "example"
    run("cmake", "--install", BUILT, "--prefix", prefix)
    assert not list(prefix.rglob("*pybind11*")) and not list(prefix.rglob("meanvalue.*.so"))
    headers = {path.relative_to(prefix / "include" / "meanvalue").as_posix() for path in prefix.rglob("*.h")}
    assert headers >= {"meanvalue.h", "deform/deformer.h", "sequence/sequence.h", "morph/morpher.h"}
    assert not [name for name in headers if name.startswith(("decode/", "linalg/", "encoding/", "hierarchy/"))]
    # A program may be compiled for other instructions than the library: Eigen takes another allocator then.
    example = ("-S", ROOT / "native" / "example", "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}")
    for each in ("", "-march=native"):
        run("cmake", *example, f"-DCMAKE_CXX_FLAGS={each}")
        run("cmake", "--build", build)
        assert "240 vertices, converged" in run(build / "bend_bar")
        assert " shapes, their coordinates sum to " in run(build / "moved")
