#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes wheels for any Linux with glibc 2.28 or later: docs/decisions/0022-packaging.md.

    build_wheels.py BUILD_FOLDER [PYTHON_VERSION ...]      3.11, 3.13 and 3.14 without one
    build_wheels.py BUILD_FOLDER sources                   no wheel: only fetches OpenMesh's sources

All is taken from Debian's archive and the Python package registry and kept in BUILD_FOLDER/portable; the wheels are put
into BUILD_FOLDER/wheels. The compiler is Zig's Clang, which brings libraries and headers for older glibc versions and
its own libc++; of the system nothing but Eigen's headers is used.
"""

import hashlib
import pathlib
import shutil
import subprocess
import sys
import tarfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
GLIBC = "2.28"
MIRROR = "http://deb.debian.org/debian"
KEYS = "/usr/share/keyrings/debian-archive-keyring.gpg"
#: The Debian release that has the headers of a Python.
SUITES = {"3.11": "bookworm", "3.13": "trixie", "3.14": "sid"}
TOOLS = ("ziglang==0.17.*", "scikit-build-core>=0.11", "pybind11==3.1.*", "auditwheel>=6.8,<7", "wheel")
LARGEST = 8 * 2**20  # bytes of a wheel
#: What a wheel is made of, but for its description (README.md), which changes with every figure in it.
SOURCES = (
    "CMakeLists.txt", "pyproject.toml", "LICENSE", "NOTICE", "packaging/build_wheels.py",
    "native/CMakeLists.txt", "native/meanvalue", "native/bindings",
)  # fmt: skip


def run(*command, **options):
    subprocess.run([str(part) for part in command], check=True, **options)


def install_tools(work):
    """A virtual environment with compiler and packers; returns its bin folder."""
    tools = work / "tools"
    if not (tools / "ready").exists():
        run(sys.executable, "-m", "venv", "--clear", tools)
        run(tools / "bin/pip", "install", "-q", *TOOLS)
        (tools / "ready").touch()
    return tools / "bin"


class Archive:
    """Debian's archive in the suites given, read by apt with lists of its own: the machine's stay as they are."""

    def __init__(self, work):
        self._work = work / "apt"
        self._options = []
        for name in ("lists/partial", "cache/archives/partial"):
            (self._work / name).mkdir(parents=True, exist_ok=True)
        sources = [f"deb [signed-by={KEYS}] {MIRROR} {suite} main" for suite in SUITES.values()]
        sources.append(f"deb-src [signed-by={KEYS}] {MIRROR} bookworm main")
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

    def sources(self, package):
        self._apt("source", "--download-only", package)
        return next(self._work.glob(f"{package}_*.orig.tar.*"))

    def package(self, name, suite):
        self._apt("download", f"{name}/{suite}")
        return max(self._work.glob(f"{name}_*.deb"))


def fetch(work, versions):
    """OpenMesh's sources and the headers of each Python, where they are missing."""
    missing = [version for version in versions if not (work / f"python{version}").exists()]
    openmesh = work / "openmesh"
    if not missing and openmesh.exists():
        return
    archive = Archive(work)
    if not openmesh.exists():
        unpacked = work / "openmesh-unpacking"
        shutil.rmtree(unpacked, ignore_errors=True)
        with tarfile.open(archive.sources("openmesh")) as sources:
            sources.extractall(unpacked)
        next(unpacked.iterdir()).rename(openmesh)
        unpacked.rmdir()
    for version in missing:
        unpack_headers(archive.package(f"libpython{version}-dev", SUITES[version]), work / f"python{version}")


def unpack_headers(package, folder):
    """Debian's headers of a Python, such that they need no other folder of includes."""
    unpacked = folder.with_name(f"{folder.name}-unpacking")
    run("dpkg", "-x", package, unpacked)
    headers = next((unpacked / "usr/include").glob("python3.*"))
    # Debian's own pyconfig.h only includes that of the processor, by a path below /usr/include.
    shutil.copy(unpacked / "usr/include/x86_64-linux-gnu" / headers.name / "pyconfig.h", headers)
    headers.rename(folder)
    shutil.rmtree(unpacked)


def write_toolchain(work, tools):
    """A file for CMake, and the compiler's parts as commands of one word. Returns its path."""
    zig = subprocess.run(
        [tools / "python", "-c", "import ziglang; print(ziglang.__path__[0] + '/zig')"],
        check=True, capture_output=True, text=True,
    ).stdout.strip()  # fmt: skip
    commands = {"ar": "ar", "ranlib": "ranlib"}
    commands |= {name: f"{name} -target x86_64-linux-gnu.{GLIBC}" for name in ("cc", "c++")}
    for name, call in commands.items():
        path = work / f"zig-{name}"
        # Zig compiles its libc++ at the first call and keeps it.
        path.write_text(f'#!/bin/sh\nexport ZIG_GLOBAL_CACHE_DIR="{work}/zig-cache"\nexec "{zig}" {call} "$@"\n')
        path.chmod(0o755)
    toolchain = work / "toolchain.cmake"
    toolchain.write_text(
        "set(CMAKE_SYSTEM_NAME Linux)\n"
        "set(CMAKE_SYSTEM_PROCESSOR x86_64)\n"
        f'set(CMAKE_C_COMPILER "{work}/zig-cc")\n'
        f'set(CMAKE_CXX_COMPILER "{work}/zig-c++")\n'
        f'set(CMAKE_AR "{work}/zig-ar" CACHE FILEPATH "")\n'
        f'set(CMAKE_RANLIB "{work}/zig-ranlib" CACHE FILEPATH "")\n'
    )
    return toolchain


def cmake_options(work, toolchain, version):
    abi = f"cpython-{version.replace('.', '')}-x86_64-linux-gnu"
    return {
        "CMAKE_TOOLCHAIN_FILE": toolchain,
        "CMAKE_INTERPROCEDURAL_OPTIMIZATION": "OFF",
        # Zig's defaults are otherwise. Of -O3 it makes -O2; what it does not look at comes after that, and counts.
        "CMAKE_CXX_FLAGS": "-g0 -fomit-frame-pointer -Xclang -O3",
        "MEANVALUE_OPENMESH_SOURCE": work / "openmesh",
        "Python_INCLUDE_DIR": work / f"python{version}",
        "Python_SOABI": abi,
        # pybind11 would take the Python that runs, or the one before.
        "PYTHON_MODULE_EXTENSION": f".{abi}.so",
        "PYTHON_MODULE_DEBUG_POSTFIX": "",
        "PYTHON_IS_DEBUG": "OFF",
    }


def digest():
    """Of all that a wheel is made of here."""
    found = hashlib.sha256()
    for name in SOURCES:
        for path in sorted((ROOT / name).rglob("*")) or [ROOT / name]:
            if path.is_file() and "__pycache__" not in path.parts:
                found.update(f"{path.relative_to(ROOT)}\0{path.stat().st_size}\0".encode() + path.read_bytes())
    return found.hexdigest()


def build_if_changed(work, output, tools, toolchain, version):
    """As build(), unless the wheel that is there was made of the same."""
    record, made_of = work / f"made-{version}", digest()
    if record.exists():
        name, before = record.read_text().split()
        if before == made_of and (output / name).exists():
            return output / name
    wheel = build(work, output, tools, toolchain, version)
    record.write_text(f"{wheel.name} {made_of}")
    return wheel


def build(work, output, tools, toolchain, version):
    """Compiles for a Python, retags and checks. Returns the wheel's path in `output`.

    In one folder for all Pythons: of the next one only what knows Python, the bindings, is compiled again.
    """
    raw = work / f"raw-{version}"
    shutil.rmtree(raw, ignore_errors=True)
    arguments = [f"--config-settings=build-dir={work}/cmake"]
    arguments += [
        f"--config-settings=cmake.define.{name}={value}"
        for name, value in cmake_options(work, toolchain, version).items()
    ]
    run(tools / "pip", "wheel", "-q", ROOT, "--no-build-isolation", "--no-deps", "-w", raw, *arguments)
    tag = f"cp{version.replace('.', '')}"
    # scikit-build-core names the Python that it runs in, which need not be the one compiled for.
    run(
        tools / "wheel",
        "tags",
        "--remove",
        "--python-tag",
        tag,
        "--abi-tag",
        tag,
        next(raw.iterdir()),
        stdout=subprocess.DEVNULL,
    )
    platform = f"manylinux_{GLIBC.replace('.', '_')}_x86_64"
    # Fails where a symbol is newer than that, or a library is needed that is not on every system. None is copied into
    # the wheel, so nothing has to be patched.
    run(
        tools / "auditwheel",
        "repair",
        "--plat",
        platform,
        "--only-plat",
        "--patcher",
        "none",
        "-w",
        raw / "repaired",
        next(raw.glob("*.whl")),
    )
    wheel = next((raw / "repaired").iterdir())
    if wheel.stat().st_size > LARGEST:
        raise SystemExit(f"{wheel.name} has {wheel.stat().st_size} bytes; {LARGEST} are the most")
    output.mkdir(parents=True, exist_ok=True)
    for old in output.glob(f"*-{tag}-*.whl"):
        old.unlink()
    return pathlib.Path(shutil.move(wheel, output / wheel.name))


def main(arguments):
    build_folder, *versions = arguments
    work = pathlib.Path(build_folder).resolve() / "portable"
    work.mkdir(parents=True, exist_ok=True)
    if versions == ["sources"]:
        fetch(work, [])
        return
    versions = versions or list(SUITES)
    for version in versions:
        if version not in SUITES:
            raise SystemExit(f"no Debian release is known for Python {version}; there are: {', '.join(SUITES)}")
    tools = install_tools(work)
    fetch(work, versions)
    toolchain = write_toolchain(work, tools)
    for version in versions:
        print(build_if_changed(work, work.parent / "wheels", tools, toolchain, version))


if __name__ == "__main__":
    main(sys.argv[1:])
