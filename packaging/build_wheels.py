#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes wheels for Linux with glibc 2.28 or later, Windows and macOS: docs/decisions/0022-packaging.md.

    build_wheels.py BUILD_FOLDER [--system linux|windows|macos] [--arch x86_64|aarch64] [PYTHON_VERSION ...]
    build_wheels.py BUILD_FOLDER all           for each system and processor, the Pythons of Blender
    build_wheels.py BUILD_FOLDER sources       no wheel: only fetches OpenMesh's sources

All is taken from Debian's archive and the Python package registry and kept in BUILD_FOLDER/portable; the wheels are put
into BUILD_FOLDER/wheels. The compiler is Zig's Clang, which brings libraries and headers of other systems and its own
libc++; of the system nothing but Eigen's headers is used.
"""

import argparse
import hashlib
import os
import pathlib
import shutil
import subprocess
import zipfile

from wheel_parts import SUITES, check_binary, fetch, install_tools, run
from wheel_targets import TARGETS, cmake_options, write_toolchain

ROOT = pathlib.Path(__file__).resolve().parents[1]
LARGEST = 3 * 2**19  # bytes of a wheel
#: What a wheel is made of, but for its description (README.md), which changes with every figure in it.
SOURCES = (
    "CMakeLists.txt", "pyproject.toml", "native/LICENSE", "NOTICE", "packaging/build_wheels.py",
    "packaging/check_binary.py", "packaging/own_symbols.py", "packaging/wheel_parts.py",
    "packaging/wheel_targets.py", "native/CMakeLists.txt", "native/include", "native/meanvalue", "native/bindings",
)  # fmt: skip


def digest():
    """Of all that a wheel is made of here."""
    found = hashlib.sha256()
    for name in SOURCES:
        for path in sorted((ROOT / name).rglob("*")) or [ROOT / name]:
            if path.is_file() and "__pycache__" not in path.parts:
                found.update(f"{path.relative_to(ROOT)}\0{path.stat().st_size}\0".encode() + path.read_bytes())
    return found.hexdigest()


def build_if_changed(work, output, tools, target, version, parts):
    """As build(), unless the wheel that is there was made of the same. `work` is the target's own folder."""
    record, made_of = work / f"made-{version}", digest()
    if record.exists():
        name, before = record.read_text().split()
        if before == made_of and (output / name).exists():
            return output / name
    wheel = build(work, output, tools, target, version, parts)
    record.write_text(f"{wheel.name} {made_of}")
    return wheel


def build(work, output, tools, target, version, parts):
    """Compiles for a Python, retags and checks. Returns the wheel's path in `output`.

    In one folder for all Pythons: of the next one only what knows Python, the bindings, is compiled again.
    """
    raw = work / f"raw-{version}"
    shutil.rmtree(raw, ignore_errors=True)
    toolchain = write_toolchain(work, tools, target)
    arguments = [f"--config-settings=build-dir={work}/cmake"]
    arguments += [
        f"--config-settings=cmake.define.{name}={value}"
        for name, value in cmake_options(toolchain, target, version, parts).items()
    ]
    run(tools / "pip", "wheel", "-q", ROOT, "--no-build-isolation", "--no-deps", "-w", raw, *arguments)
    tag = f"cp{version.replace('.', '')}"
    # scikit-build-core names the Python and the system that it runs in, which need not be those compiled for.
    tags = [f"--python-tag={tag}", f"--abi-tag={tag}", f"--platform-tag={target.platform}"]
    run(tools / "wheel", "tags", "--remove", *tags, next(raw.iterdir()), stdout=subprocess.DEVNULL)
    wheel = next(raw.glob("*.whl"))
    check(tools, wheel, target.suffix_of(version))
    if wheel.stat().st_size > LARGEST:
        raise SystemExit(f"{wheel.name} has {wheel.stat().st_size} bytes; {LARGEST} are the most")
    output.mkdir(parents=True, exist_ok=True)
    for old in output.iterdir():
        if target.owns(old.name, version):
            old.unlink()
    return pathlib.Path(shutil.move(wheel, output / wheel.name))


def check(tools, wheel, suffix):
    """@throws SystemExit unless its module is called as that Python wants it, and passes check_binary.py."""
    unpacked = wheel.with_suffix(".module")
    with zipfile.ZipFile(wheel) as archive:
        name = f"meanvalue.{suffix}"
        if name not in archive.namelist():
            raise SystemExit(f"{wheel.name} has no {name}")
        archive.extract(name, unpacked)
    run(tools / "python", check_binary(), unpacked / name)


def main():
    parser = argparse.ArgumentParser(description="Makes wheels of the solver.")
    parser.add_argument("build_folder", type=pathlib.Path)
    parser.add_argument("--system", choices=sorted({system for system, _ in TARGETS}), default="linux")
    parser.add_argument("--arch", choices=("x86_64", "aarch64"), default="x86_64")
    parser.add_argument("what", nargs="*", metavar="all|sources|VERSION", help=f"Pythons, of {', '.join(SUITES)}")
    options = parser.parse_intermixed_args()
    # The time in every file that is packed: the same sources make the same bytes.
    os.environ.setdefault("SOURCE_DATE_EPOCH", "315532800")
    folder = options.build_folder.resolve()
    work = folder / "portable"
    work.mkdir(parents=True, exist_ok=True)
    if options.what == ["sources"]:
        fetch(work, None, None, [])
        return
    if options.what == ["all"]:
        wanted = [(target, target.pythons) for target in TARGETS.values()]
    elif (options.system, options.arch) in TARGETS:
        target = TARGETS[options.system, options.arch]
        wanted = [(target, options.what or target.pythons)]
    else:
        parser.error(f"there is no wheel for {options.system} on {options.arch}")
    for version in options.what:
        if version != "all" and version not in SUITES:
            parser.error(f"no Debian release is known for Python {version}; there are: {', '.join(SUITES)}")
    tools = install_tools(work)
    for target, versions in wanted:
        parts = fetch(work, tools, target, versions)
        for version in versions:
            place = work / f"{target.name}-{target.processor}"
            place.mkdir(exist_ok=True)
            print(build_if_changed(place, folder / "wheels", tools, target, version, parts[version]), flush=True)


if __name__ == "__main__":
    main()
