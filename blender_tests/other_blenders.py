#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The in-Blender and the interface tests on other Blenders than this Debian's, with the extension installed in them;
and the module's tests on its wheels, without a Blender.

    other_blenders.py list VERSION                names of the suites that there are for it, or for `wheel`
    other_blenders.py run BUILD_FOLDER SUITE [PYTEST_ARGUMENT...]

`run` takes the zip from MEANVALUE_ADDON_ZIP, wheels from BUILD_FOLDER/wheels. What can't be had here ends with status
77 and a last line that says why.
"""

import dataclasses
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "packaging"))
from debian_chroot import Chroot, UnavailableError  # noqa: E402

SKIPPED = 77
TESTS = ("blender_tests/unit", "blender_tests/scenarios")
PYTEST = ("-q", "-rs", "-p", "no:cacheprovider")
#: Of another Debian: its Blender, a display, pytest; and what Blender's Python module loads.
PACKAGES = (
    "blender", "xvfb", "libgl1-mesa-dri", "python3-pytest", "python3-numpy",
    "libgl1", "libegl1", "libxrender1", "libxfixes3", "libxi6", "libxxf86vm1", "libsm6", "libice6", "libxkbcommon0",
    "libgomp1",
)  # fmt: skip
#: What a Debian's Blender imports without that its package asks for it.
MORE_PACKAGES = {"trixie": (), "sid": ("python3-cattr", "python3-requests")}
#: Platforms of the wheels that are taken: for glibc up to that of this Debian.
PLATFORMS = tuple(f"manylinux_2_{minor}_x86_64" for minor in range(17, 37))


@dataclasses.dataclass(frozen=True)
class Suite:
    """Tests of a kind (`blender`, `interface`, `module`) on a Blender, or `wheel` on a Python; `debian` None is the
    one that runs here."""

    kind: str
    version: str
    debian: str | None
    python: str

    @property
    def name(self):
        return f"{self.kind}-{self.version}"


def _debians(version, debian, python):
    return [Suite(kind, version, debian, python) for kind in ("blender", "interface")]


#: Debian's own Blender with a window where a Debian has that version, and Python's registry has most as a module.
SUITES = {
    "4.2": [Suite("module", "4.2", None, "3.11")],
    "4.3": _debians("4.3", "trixie", "3.13"),
    "4.5": [Suite("module", "4.5", None, "3.11")],
    "5.0": [Suite("module", "5.0", None, "3.11")],
    "5.1": [Suite("module", "5.1", "trixie", "3.13")],
    "5.2": [*_debians("5.2", "sid", "3.14"), Suite("module", "5.2", "trixie", "3.13")],
    "wheel": [
        Suite("wheel", "3.11", None, "3.11"),
        Suite("wheel", "3.13", "trixie", "3.13"),
        Suite("wheel", "3.14", "sid", "3.14"),
    ],
}
#: Host tests that need the module, by how they begin.
OF_MODULE = re.compile(r'^(import meanvalue|(meanvalue = )?pytest.importorskip\("meanvalue")', re.MULTILINE)


class Place:
    """Where a suite runs: on this system, or in a chroot with another Debian."""

    def __init__(self, suite, build):
        self._build = build
        self._chroot = None
        if suite.debian:
            self._chroot = Chroot(build / f"chroot-{suite.debian}")
            self._chroot.make(suite.debian, PACKAGES + MORE_PACKAGES[suite.debian])

    def run(self, command, environment, **options):
        if self._chroot is None:
            return subprocess.run(command, cwd=ROOT, env={**os.environ, **environment}, **options)
        folders, data = [ROOT], os.environ.get("MEANVALUE_DATA", ROOT.parent / "shared" / "data")
        folders += [folder for folder in (self._build, pathlib.Path(data).resolve()) if folder.exists()]
        ours = {name: value for name, value in os.environ.items() if name.startswith("MEANVALUE_")}
        environment = {**ours, "MEANVALUE_DATA": str(folders[-1]), **environment}
        return self._chroot.run(command, folders, environment, **options)


def user_folder(build, suite):
    """Variables for a user folder without anything in it."""
    user = build / "other-blenders" / suite.name
    shutil.rmtree(user, ignore_errors=True)
    names = ("scripts", "config", "datafiles", "extensions")
    for name in (*names, "scripts/addons"):
        (user / name).mkdir(parents=True)
    return {f"BLENDER_USER_{name.upper()}": str(user / name) for name in names}


def install(target, suite, wanted, stamp="", platforms=PLATFORMS):
    """What is `wanted`, for the suite's Python, by this system's pip, unless it is there with the same stamp.

    platforms: tags of the wheels that may be taken. @throws UnavailableError.
    """
    ready = f"{wanted} {stamp}"
    if (target / "ready").exists() and (target / "ready").read_text() == ready:
        return
    fresh = target.with_name(f"{target.name}.new")  # what is there stays until there is something better
    shutil.rmtree(fresh, ignore_errors=True)
    log = target.with_name(f"{target.name}.log")
    command = [sys.executable, "-m", "pip", "install", "-q", "--only-binary", ":all:", "--target", fresh]
    command += ["--python-version", suite.python, "--implementation", "cp"]
    if suite.debian:  # for another Python: pip 23 compares what packages ask for with the one that runs
        command.append("--ignore-requires-python")
    for platform in platforms:
        command += ["--platform", platform]
    with log.open("w") as output:
        done = subprocess.run([*command, *wanted], stdout=output, stderr=subprocess.STDOUT)
    if done.returncode:
        raise UnavailableError(f"{', '.join(wanted)} for Python {suite.python} could not be had; see {log}")
    (fresh / "ready").write_text(ready)
    shutil.rmtree(target, ignore_errors=True)
    fresh.rename(target)


def install_module(build, suite):
    """Blender's module, in the folder returned. @throws UnavailableError."""
    target = build / f"bpy-{suite.version}-python{suite.python}"
    install(target, suite, [f"bpy=={suite.version}.*"])
    return target


def install_wheel(build, suite):
    """Our module, numpy, which is all that it needs, and pytest, in the folder returned. @throws UnavailableError."""
    target = build / f"wheel-python{suite.python}"
    wheel = next((build / "wheels").glob(f"*-cp{suite.python.replace('.', '')}-manylinux*_x86_64.whl"), None)
    if wheel is None:
        raise UnavailableError(f"there is no wheel for Python {suite.python}")
    install(target, suite, [str(wheel), "pytest"], hashlib.sha256(wheel.read_bytes()).hexdigest())
    return target


def check_wheel(suite):
    """@throws UnavailableError unless the zip has a solver for the suite's Python."""
    import zipfile

    tag = f"cp{suite.python.replace('.', '')}"
    with zipfile.ZipFile(os.environ["MEANVALUE_ADDON_ZIP"]) as archive:
        if not any(f"-{tag}-" in name for name in archive.namelist() if name.endswith(".whl")):
            raise UnavailableError(f"the extension has no wheel for Python {suite.python} of Blender {suite.version}")


def check_version(place, suite):
    """@throws UnavailableError if that Debian has moved on to another Blender."""
    shown = place.run(["blender", "--version"], {}, capture_output=True, text=True).stdout.splitlines()
    if not shown or not shown[0].startswith(f"Blender {suite.version}."):
        raise UnavailableError(f"Debian {suite.debian} has {shown[0] if shown else 'a Blender that does not start'}")


def run(build, suite, arguments):
    """Exit status of pytest. @throws UnavailableError."""
    if suite.kind != "wheel":
        check_wheel(suite)
    place, environment = Place(suite, build), {}
    if suite.kind == "wheel":
        files = sorted((ROOT / "blender_tests" / "host").glob("test_*.py"))
        files = [file.relative_to(ROOT) for file in files if OF_MODULE.search(file.read_text())]
        # -S: nothing of what Debian has for its Python; a file whose import of the module fails would only be skipped.
        python = [f"/usr/bin/python{suite.python}", "-S"]
        command = [*python, "-m", "pytest", *PYTEST, *arguments, *map(str, files)]
        environment["PYTHONPATH"] = str(install_wheel(build, suite))
        imported = "import meanvalue, sys; sys.exit(not meanvalue.__file__.startswith(sys.argv[1]))"
        if place.run([*python, "-c", imported, environment["PYTHONPATH"]], environment).returncode:
            print("the module is not the wheel's")
            return 1
    elif suite.kind == "interface":
        command = ["/usr/bin/python3", "-m", "pytest", *PYTEST, *arguments, "blender_tests/ui"]
        environment["MEANVALUE_UI_OUTPUT"] = str(build / f"ui-{suite.version}")
    elif suite.kind == "blender":
        command = ["blender", "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1", "--python"]
        command += ["blender_tests/run.py", "--", *PYTEST, *arguments, *TESTS]
        environment |= user_folder(build, suite)
    else:
        modules = install_module(build, suite)
        command = [f"/usr/bin/python{suite.python}", "blender_tests/run.py", "--", *PYTEST, *arguments, *TESTS]
        environment |= {"PYTHONPATH": str(modules), **user_folder(build, suite)}
    if suite.kind in ("blender", "interface"):
        check_version(place, suite)
    return place.run(command, environment).returncode


def main(arguments):
    task, *rest = arguments
    if task == "list":
        if rest[0] not in SUITES:
            versions = [version for version in SUITES if version != "wheel"]
            raise SystemExit(f"no Blender {rest[0]} is known; there are: 3.4, {', '.join(versions)}")
        print(*(suite.name for suite in SUITES[rest[0]]), sep="\n")
        return 0
    build, name, *pytest_arguments = rest
    suite = next(suite for suites in SUITES.values() for suite in suites if suite.name == name)
    try:
        return run(pathlib.Path(build).resolve(), suite, pytest_arguments)
    except UnavailableError as reason:
        print(reason)
        return SKIPPED


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
