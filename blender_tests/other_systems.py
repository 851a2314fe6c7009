#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tests of the wheels for other systems and processors, and of the add-on in Blender's module there: Windows in
Wine, ARM in QEMU, and what this runs on.

    other_systems.py BUILD_FOLDER windows|aarch64|here host|blender [PYTEST_ARGUMENT...]

Each file of tests has a process of its own, since one that ends does not take the others along. Wheels are taken from
BUILD_FOLDER/wheels, also Linux' own, to compare with; Windows' Python from BUILD_FOLDER/portable. What can't be had
here ends with status 77 and a last line that says why.
"""

import collections
import contextlib
import dataclasses
import hashlib
import os
import pathlib
import platform
import re
import subprocess
import sys
import threading
import time

from other_blenders import PYTEST, ROOT, SKIPPED, Suite, install, install_wheel, user_folder
from ui.harness.display import Display

sys.path.insert(0, str(ROOT / "packaging"))
import build_extension
from debian_chroot import Chroot, UnavailableError

PYTHON = "3.11"
BLENDER = "4.5"
SECONDS_OF_A_FILE = 1800
SECONDS_OF_OUTPUT = 5
COUNTED = ("passed", "failed", "skipped", "errors")
NOTHING_COLLECTED = 5  # by pytest, of what -k leaves of a file


@dataclasses.dataclass(frozen=True)
class Here:
    """The system and the processor that this runs on, for real ones."""

    build: pathlib.Path
    platforms = ()
    numpy = "numpy"
    has_same_bits = False  # in portable mode, as Linux' own wheel, which runs on Linux alone
    python = (sys.executable,)

    @property
    def wheel_tag(self):
        systems = {"win32": "win", "darwin": "macosx_11_0", "linux": "manylinux_2_28"}
        return f"{systems[sys.platform]}_{platform.machine().lower()}"

    @contextlib.contextmanager
    def variables(self):
        yield {}

    def path(self, path):
        return str(path)


class Wine(Here):
    """Windows on this system. Its drive Z: is this system's root."""

    platforms = ("win_amd64",)
    wheel_tag = "win_amd64"
    numpy = "numpy==1.26.4"  # newer ones need a newer Wine
    has_same_bits = True

    @property
    def python(self):
        return ["wine", str(self.build / "portable" / f"windows-python{PYTHON}" / "python.exe")]

    @contextlib.contextmanager
    def variables(self):
        with Display() as display:  # to render on
            yield {"WINEPREFIX": str(self.build / "wine"), "WINEDEBUG": "-all", "DISPLAY": display.name}

    def path(self, path):
        return "Z:" + str(path).replace("/", "\\")


class Qemu(Here):
    """Debian's Python for ARM, by the emulator that runs one program: nothing of this system is changed for it."""

    platforms = tuple(f"manylinux_2_{minor}_aarch64" for minor in range(17, 37))
    wheel_tag = "manylinux_2_28_aarch64"
    numpy = Wine.numpy
    has_same_bits = True

    @property
    def python(self):
        return [str(self.build / "debian-arm64" / "usr" / "bin" / "emulated-python")]

    @contextlib.contextmanager
    def variables(self):
        folder = self.build / "debian-arm64"
        Chroot(folder).make("bookworm", [f"python{PYTHON}"], "arm64")
        # Called by a path in its own folder, Python knows where it is, and tests start it by what it says.
        launcher = pathlib.Path(*self.python)
        launcher.write_text(f'#!/bin/sh\nexec qemu-aarch64 -L {folder} -0 "$0" {folder}/usr/bin/python{PYTHON} "$@"\n')
        launcher.chmod(0o755)
        yield {}


TARGETS = {"windows": Wine, "aarch64": Qemu, "here": Here}


def wheel_of(build, system):
    """@throws UnavailableError."""
    wheel = next((build / "wheels").glob(f"*-cp{PYTHON.replace('.', '')}-{system.wheel_tag}.whl"), None)
    if wheel is None:
        raise UnavailableError(f"there is no wheel for Python {PYTHON} on {system.wheel_tag}")
    return wheel


def install_all(build, system, kind):
    """What a kind of suite needs, in the folder returned. @throws UnavailableError."""
    target = build / f"{kind}-{system.wheel_tag}"
    wanted, stamp = ["pytest", system.numpy], ""
    if kind == "blender":
        wanted.append(f"bpy=={BLENDER}.*")
    else:
        wheel = wheel_of(build, system)
        wanted, stamp = [*wanted, str(wheel)], hashlib.sha256(wheel.read_bytes()).hexdigest()
    install(target, Suite(kind, BLENDER, None, PYTHON), wanted, stamp, system.platforms)
    return target


def compare_bits(build, system, environment):
    """Counter of one test: that portable meshes are solved to the same bits there and by Linux' wheel."""
    inputs, program = build / "test" / "portable.npz", "blender_tests/support/portable_bits.py"
    inputs.parent.mkdir(exist_ok=True)
    ours = {**os.environ, "PYTHONPATH": str(install_wheel(build, Suite("wheel", PYTHON, None, PYTHON)))}
    run_one([sys.executable, program, "make", str(inputs)], ours)
    digests = [
        run_one([*python, program, "digest", system.path(inputs) if there else str(inputs)], variables)
        for there, python, variables in ((False, [sys.executable], ours), (True, system.python, environment))
    ]
    print("digests of portable answers and of the C library, here and there:", *digests, sep="\n")
    alike = all(status == 0 for status, _ in digests) and len({said.split()[-2] for _, said in digests}) == 1
    return collections.Counter(passed=1) if alike else collections.Counter(failed=1)


def files_and_options(kind, arguments):
    """Which files of tests are run, and what else pytest is told."""
    named = [argument for argument in arguments if (ROOT / argument.split("::")[0]).exists()]
    folders = {"host": ("host",), "blender": ("unit", "scenarios")}[kind]
    every = [file for folder in folders for file in sorted((ROOT / "blender_tests" / folder).glob("test_*.py"))]
    options = [argument for argument in arguments if argument not in named]
    return named or [file.relative_to(ROOT).as_posix() for file in every], options


def counts(output):
    """Counter of what pytest's last line says; empty if it has not come so far."""
    lines = [line for line in output.splitlines() if re.search(r" in [\d.]+s", line)]
    found = re.findall(r"(\d+) (\w+)", lines[-1].rpartition(" in ")[0]) if lines else []
    return collections.Counter({"errors" if name == "error" else name: int(count) for count, name in found})


def run(build, name, kind, arguments):
    """Exit status. @throws UnavailableError."""
    system = TARGETS[name](build)
    with system.variables() as variables:
        environment = {**os.environ, **variables, "PYTHONPYCACHEPREFIX": system.path(build / f"bytecode-{name}")}
        return run_files(build, name, kind, arguments, system, environment)


def run_files(build, name, kind, arguments, system, environment):
    environment["PYTHONPATH"] = system.path(install_all(build, system, kind))
    command = [*system.python, "-m", "pytest"]
    if kind == "blender":
        extension = build / f"test-{name}" / "extension.zip"
        build_extension.build(extension, [wheel_of(build, system)])
        environment["MEANVALUE_ADDON_ZIP"] = system.path(extension)
        command = [*system.python, "blender_tests/run.py", "--"]
    files, options = files_and_options(kind, arguments)
    total, started = collections.Counter(), time.monotonic()
    if kind == "host" and system.has_same_bits and not arguments:
        total += compare_bits(build, system, environment)
    for file in files:
        if kind == "blender":
            user = user_folder(build, Suite(f"blender-{name}", BLENDER, None, PYTHON))
            environment |= {variable: system.path(path) for variable, path in user.items()}
        total += run_file(file, [*command, *PYTEST, *options, file], environment)
    said = ", ".join(f"{total[name]} {name}" for name in COUNTED if total[name])
    print(f"{said or 'nothing'} in {time.monotonic() - started:.1f}s")
    return 1 if total["failed"] + total["errors"] or not total["passed"] else 0


def run_file(file, command, environment):
    """Counter of its tests. Prints why some were skipped, and of a file that failed what it said."""
    status, output = run_one(command, environment)
    found = counts(output)
    if status not in (0, 1, NOTHING_COLLECTED) or not found:
        print(f"{file}: the process ended with status {status}")
        found["failed"] += 1
    print(file, dict(found))
    if not (found["failed"] or found["errors"]):
        output = "\n".join(line for line in output.splitlines() if line.startswith("SKIPPED"))
    print(output, flush=True)
    return found


def run_one(command, environment):
    """(status, output). Wine's programs take nothing but pipes, and what Wine starts along keeps these open."""
    process = subprocess.Popen(
        command, cwd=ROOT, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    output = []
    reader = threading.Thread(target=lambda: output.extend(iter(process.stdout.read1, b"")), daemon=True)
    reader.start()
    try:
        status = process.wait(SECONDS_OF_A_FILE)
    except subprocess.TimeoutExpired:
        process.kill()
        status = "none: it did not end"
    reader.join(SECONDS_OF_OUTPUT)
    return status, b"".join(output).decode(errors="replace")


if __name__ == "__main__":
    folder, *rest = sys.argv[1:]
    try:
        sys.exit(run(pathlib.Path(folder).resolve(), rest[0], rest[1], rest[2:]))
    except UnavailableError as reason:
        print(reason)
        sys.exit(SKIPPED)
