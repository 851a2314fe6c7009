# SPDX-License-Identifier: GPL-3.0-or-later
"""The systems and processors that build_wheels.py makes wheels for, and how CMake is told of each."""

import dataclasses
import fnmatch
import pathlib
import subprocess
import sys

GLIBC = "2.28"
OWN_SYMBOLS = pathlib.Path(__file__).with_name("own_symbols.py")


@dataclasses.dataclass(frozen=True)
class Target:
    """`system` and `processor` as CMake says them, `zig` as Zig's compiler does; `suffix` of the module and `platform`
    of the wheel as Python does, with {} for the digits of its version."""

    name: str
    system: str
    processor: str
    zig: str
    suffix: str
    platform: str
    #: For which wheels are made if none is named: those of Blender's own builds.
    pythons: tuple = ("3.11", "3.13")

    def suffix_of(self, version):
        return self.suffix.format(version.replace(".", ""))

    def owns(self, wheel, version):
        """True if a file called `wheel` is made for this target and a Python."""
        return fnmatch.fnmatch(wheel, f"*-cp{version.replace('.', '')}-*{self.platform}.whl")


TARGETS = {
    (target.name, target.processor): target
    for target in (
        Target(
            "linux", "Linux", "x86_64", f"x86_64-linux-gnu.{GLIBC}", "cpython-{}-x86_64-linux-gnu.so",
            f"manylinux_{GLIBC.replace('.', '_')}_x86_64", ("3.11", "3.13", "3.14"),
        ),
        Target(
            "linux", "Linux", "aarch64", f"aarch64-linux-gnu.{GLIBC}", "cpython-{}-aarch64-linux-gnu.so",
            f"manylinux_{GLIBC.replace('.', '_')}_aarch64",
        ),
        Target("windows", "Windows", "x86_64", "x86_64-windows-gnu", "cp{}-win_amd64.pyd", "win_amd64"),
        Target("macos", "Darwin", "x86_64", "x86_64-macos.11.0", "cpython-{}-darwin.so", "macosx_11_0_x86_64"),
        Target("macos", "Darwin", "aarch64", "aarch64-macos.11.0", "cpython-{}-darwin.so", "macosx_11_0_arm64"),
    )
}  # fmt: skip


def zig(tools):
    """Path of Zig in the virtual environment."""
    call = [tools / "python", "-c", "import ziglang; print(ziglang.__path__[0] + '/zig')"]
    return subprocess.run(call, check=True, capture_output=True, text=True).stdout.strip()


def write_if_changed(path, text):
    """So that what caches what was compiled knows the compiler by the time of this file."""
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def write_toolchain(work, tools, target):
    """A file for CMake in `work`, and beside it the compiler's parts as commands of one word. Returns its path."""
    work.mkdir(parents=True, exist_ok=True)
    commands = {name: name for name in ("ar", "ranlib", "rc")}
    commands |= {name: f"{name} -target {target.zig}" for name in ("cc", "c++")}
    for name, call in commands.items():
        path = work / f"zig-{name}"
        # Zig compiles its libc++ at the first call and keeps it.
        cache = work.parent / "zig-cache"
        write_if_changed(path, f'#!/bin/sh\nexport ZIG_GLOBAL_CACHE_DIR="{cache}"\nexec "{zig(tools)}" {call} "$@"\n')
        path.chmod(0o755)
    toolchain = work / "toolchain.cmake"
    toolchain.write_text(
        f"set(CMAKE_SYSTEM_NAME {target.system})\n"
        f"set(CMAKE_SYSTEM_PROCESSOR {target.processor})\n"
        f'set(CMAKE_C_COMPILER "{work}/zig-cc")\n'
        f'set(CMAKE_CXX_COMPILER "{work}/zig-c++")\n'
        f'set(CMAKE_RC_COMPILER "{work}/zig-rc")\n'
        f'set(CMAKE_AR "{work}/zig-ar" CACHE FILEPATH "")\n'
        f'set(CMAKE_RANLIB "{work}/zig-ranlib" CACHE FILEPATH "")\n'
        # Tools of this system that do not know the binaries of others. Zig's linker strips.
        'set(CMAKE_STRIP "/bin/true" CACHE FILEPATH "")\n'
        'set(CMAKE_INSTALL_NAME_TOOL "/bin/true" CACHE FILEPATH "")\n'
    )
    # Read after CMake's own settings of a system: Zig's linker crashes on macOS' -bundle. Python loads either.
    (work / "rules.cmake").write_text(
        "if(APPLE)\n"
        '  set(CMAKE_CXX_CREATE_SHARED_MODULE "<CMAKE_CXX_COMPILER> <LANGUAGE_COMPILE_FLAGS> <LINK_FLAGS> -dynamiclib '
        f'-o <TARGET> <OBJECTS> <LINK_LIBRARIES>" "{sys.executable} {OWN_SYMBOLS} <TARGET>")\n'
        "endif()\n"
    )
    return toolchain


def cmake_options(toolchain, target, version, parts):
    """`parts`: {option: path} of what is not made here, see wheel_parts.fetch()."""
    suffix = target.suffix_of(version)
    return {
        "CMAKE_TOOLCHAIN_FILE": toolchain,
        "CMAKE_USER_MAKE_RULES_OVERRIDE": toolchain.with_name("rules.cmake"),
        "CMAKE_INTERPROCEDURAL_OPTIMIZATION": "OFF",
        # Zig's defaults are otherwise. Of -O3 it makes -O2; what it does not look at comes after that, and counts.
        "CMAKE_CXX_FLAGS": "-g0 -fomit-frame-pointer -Xclang -O3",
        # Only PyInit_meanvalue is to be seen from outside (native/bindings/exported_symbols.map says it on Linux).
        "CMAKE_CXX_VISIBILITY_PRESET": "hidden",
        "CMAKE_VISIBILITY_INLINES_HIDDEN": "ON",
        "CMAKE_MODULE_LINKER_FLAGS": "-s",
        # pybind11 would take the Python that runs, or the one before.
        "Python_SOABI": suffix.rpartition(".")[0],
        "PYTHON_MODULE_EXTENSION": f".{suffix}",
        "PYTHON_MODULE_DEBUG_POSTFIX": "",
        "PYTHON_IS_DEBUG": "OFF",
        **parts,
    }
