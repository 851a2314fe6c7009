# SPDX-License-Identifier: GPL-3.0-or-later
"""What build_wheels.py needs and does not make: parts of Debian's archive and the Python registry, kept in a folder."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile

from wheel_targets import zig

MIRROR = "http://deb.debian.org/debian"
KEYS = "/usr/share/keyrings/debian-archive-keyring.gpg"
#: The Debian release that has the headers of a Python.
SUITES = {"3.11": "bookworm", "3.13": "trixie", "3.14": "sid"}
TOOLS = ("ziglang==0.17.*", "scikit-build-core>=0.11", "pybind11==3.1.*", "wheel", "lief==1.*")
#: Its wheels for Windows have Python's DLL for the programs that it makes.
WINDOWS_PYTHON = "panda3d==1.10.16"


def check_binary():
    return pathlib.Path(__file__).with_name("check_binary.py")


def run(*command, **options):
    return subprocess.run([str(part) for part in command], check=True, **options)


def install_tools(work):
    """A virtual environment with compiler and packers; returns its bin folder."""
    tools = work / "tools"
    ready = tools / "ready"
    if not ready.exists() or ready.read_text() != str(TOOLS):
        run(sys.executable, "-m", "venv", "--clear", tools)
        run(tools / "bin/pip", "install", "-q", *TOOLS)
        ready.write_text(str(TOOLS))
    return tools / "bin"


class Archive:
    """Debian's archive in all SUITES, read by apt with lists of its own: the machine's stay as they are."""

    def __init__(self, work):
        self._work = work / "apt"
        self._options = []
        for name in ("lists/partial", "cache/archives/partial"):
            (self._work / name).mkdir(parents=True, exist_ok=True)
        sources = [
            f"{kind} [signed-by={KEYS}] {MIRROR} {suite} main"
            for suite in SUITES.values()
            for kind in ("deb", "deb-src")
        ]
        (self._work / "sources.list").write_text("\n".join(sources) + "\n")
        settings = {
            "Dir::Etc::sourcelist": self._work / "sources.list",
            "Dir::Etc::sourceparts": "-",
            "Dir::State::lists": self._work / "lists",
            "Dir::Cache": self._work / "cache",
            "Debug::NoLocking": "true",
            "APT::Sandbox::User": "root",  # its own user may not read this folder
        }
        for name, value in settings.items():
            self._options += ["-o", f"{name}={value}"]
        self._apt("update", "-q")

    def _apt(self, *arguments):
        run("apt-get", *self._options, *arguments, cwd=self._work, stdout=subprocess.DEVNULL)

    def sources(self, package, suite):
        """An open tarfile of what Debian took from the authors."""
        self._apt("source", "--download-only", f"{package}/{suite}")
        return tarfile.open(next(self._work.glob(f"{package}_*.orig.tar.[gx]z")))

    def package(self, name, suite):
        self._apt("download", f"{name}/{suite}")
        return max(self._work.glob(f"{name}_*.deb"))


def fetch(work, tools, target, versions):
    """OpenMesh's sources, and headers and library of each Python, where they are missing.

    Returns {version: {option of CMake: path}}.
    """
    archive = None
    windows = target is not None and target.name == "windows"
    steps = [(work / "openmesh", unpack_openmesh, ())]
    steps += [(work / f"python{version}", unpack_headers, (version,)) for version in versions]
    if windows:
        steps += [(windows_python(work, version), unpack_windows, (version, tools)) for version in versions]
    for folder, unpack, arguments in steps:
        if not folder.exists():
            archive = archive or Archive(work)
            unpacking = folder.with_name(f"{folder.name}-unpacking")
            shutil.rmtree(unpacking, ignore_errors=True)
            unpack(archive, unpacking, *arguments).rename(folder)
            shutil.rmtree(unpacking, ignore_errors=True)
    parts = {}
    for version in versions:
        parts[version] = {"MEANVALUE_OPENMESH_SOURCE": work / "openmesh"}
        if windows:
            python = windows_python(work, version)
            parts[version]["Python_INCLUDE_DIR"] = python / "include"
            parts[version]["Python_LIBRARY"] = python / "libs" / f"python{version.replace('.', '')}.lib"
        else:
            parts[version]["Python_INCLUDE_DIR"] = work / f"python{version}"
    return parts


def windows_python(work, version):
    """The folder of a Python for Windows, laid out as there: python.exe, its libraries, include/, libs/ and Lib/."""
    return work / f"windows-python{version}"


def unpack_openmesh(archive, folder):
    with archive.sources("openmesh", SUITES["3.11"]) as sources:
        sources.extractall(folder)
    return next(folder.iterdir())


def unpack_headers(archive, folder, version):
    """Debian's headers of a Python, such that they need no other folder of includes.

    They serve for Linux and macOS on both processors: these agree with each other in all that the headers ask
    pyconfig.h for, as sizes of numbers.
    """
    run("dpkg", "-x", archive.package(f"libpython{version}-dev", SUITES[version]), folder)
    headers = next((folder / "usr/include").glob("python3.*"))
    # Debian's own pyconfig.h only includes that of the processor, by a path below /usr/include.
    shutil.copy(folder / "usr/include/x86_64-linux-gnu" / headers.name / "pyconfig.h", headers)
    return headers


def as_called(metadata):
    """Text of importlib.metadata as a later DLL calls it: on the class."""
    return re.sub(r"(?m)(?<!@classmethod\n)^( +)def invalidate_caches\(cls\)", r"\1@classmethod\n\g<0>", metadata)


def unpack_windows(archive, folder, version, tools):
    """A Python for Windows: what runs comes from WINDOWS_PYTHON, headers and the library in Python from its sources."""
    dll, headers, libraries = f"python{version.replace('.', '')}.dll", folder / "include", folder / "libs"
    shutil.copytree(folder.with_name(f"python{version}"), headers)
    with archive.sources(f"python{version}", SUITES[version]) as sources:
        for member in sources:
            path = pathlib.PurePath(*pathlib.PurePath(member.name).parts[1:])
            if member.isfile() and path.name in ("pyconfig.h", "pyconfig.h.in") and path.parts[0] == "PC":
                (headers / "pyconfig.h").write_bytes(sources.extractfile(member).read())
            elif path.parts[:1] == ("Lib",) and "test" not in path.parts:
                member.name = str(path)
                sources.extract(member, folder)
    run(
        tools / "pip", "download", "-q", "--no-deps", "--only-binary", ":all:", "--platform", "win_amd64",
        "--python-version", version, "-d", folder, WINDOWS_PYTHON,
    )  # fmt: skip
    wheel = next(folder.glob("*.whl"))
    with zipfile.ZipFile(wheel) as archive_of_wheel:
        for name in archive_of_wheel.namelist():
            place, _, file = name.partition("/")
            # The system has what is called api-ms, also Wine.
            if place == "deploy_libs" and not file.startswith("api-ms-"):
                (folder / file).write_bytes(archive_of_wheel.read(name))
    wheel.unlink()
    metadata = folder / "Lib/importlib/metadata/__init__.py"
    metadata.write_text(as_called(metadata.read_text()))
    names = run(tools / "python", check_binary(), "--exports", folder / dll, capture_output=True, text=True).stdout
    libraries.mkdir()
    library = (libraries / dll).with_suffix(".lib")
    definitions = library.with_suffix(".def")
    definitions.write_text(f"LIBRARY {dll}\nEXPORTS\n{names}")
    run(zig(tools), "dlltool", "-m", "i386:x86-64", "-D", dll, "-d", definitions, "-l", library)
    launcher = pathlib.Path(__file__).with_name("windows_python.c")
    run(
        zig(tools), "cc", "-target", "x86_64-windows-gnu", "-municode", "-s", launcher, library,
        "-o", folder / "python.exe", env={**os.environ, "ZIG_GLOBAL_CACHE_DIR": str(folder.parent / "zig-cache")},
    )  # fmt: skip
    return folder
