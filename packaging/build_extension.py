#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the extension (Blender 4.2 and later) of addon/, the manifest beside this file, and wheels.

build_extension.py OUTPUT_FOLDER WHEEL...

A zip for each platform that there is a wheel for, and one for all of several unless it is too large to be handy.
"""

import pathlib
import re
import sys
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "packaging" / "site"))

import manual_page  # noqa: E402

#: What Blender calls a platform, by how its wheels' platform tags end.
PLATFORMS = {
    "_x86_64": {"linux": "linux-x64", "manylinux": "linux-x64", "macosx": "macos-x64"},
    "_arm64": {"macosx": "macos-arm64"},
    "_aarch64": {"linux": "linux-arm64", "manylinux": "linux-arm64"},
    "win_amd64": {"win": "windows-x64"},
}

LARGEST_FOR_ALL = 12 * 2**20  # bytes


def version():
    return re.search(r"project\(meanvalue VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)


def platform(wheel):
    """Blender's name of the platform that a wheel is for. @throws ValueError if it has none."""
    tag = wheel.stem.split("-")[-1].split(".")[-1]
    for end, systems in PLATFORMS.items():
        if tag.endswith(end) and (found := systems.get(re.match("[a-z]+", tag).group())):
            return found
    raise ValueError(f"{wheel.name} is for a platform that Blender does not have")


def check(wheels):
    """@throws ValueError unless all are wheels of this version, one for each Python and platform."""
    if not wheels:
        raise ValueError("an extension without a wheel would have no solver")
    targets = set()
    for wheel in wheels:
        name, wheel_version, python, *_ = wheel.stem.split("-")
        if (name, wheel_version) != ("meanvalue", version()):
            raise ValueError(f"{wheel.name} is not a wheel of meanvalue {version()}")
        if (python, platform(wheel)) in targets:
            raise ValueError(f"two wheels for {python} on {platform(wheel)}")
        targets.add((python, platform(wheel)))


def manifest(wheels):
    """Text of the manifest with the parts that depend on what is packed, which stand before its first table."""
    head, table, rest = (ROOT / "packaging/blender_manifest.toml").read_text().partition("\n[permissions]")
    lines = [
        f'version = "{version()}"',
        f"platforms = {sorted({platform(wheel) for wheel in wheels})}".replace("'", '"'),
        "wheels = [",
        *(f'  "./wheels/{wheel.name}",' for wheel in sorted(wheels)),
        "]",
    ]
    head = "\n".join(line for line in head.splitlines() if not line.startswith("#"))
    return head + "\n" + "\n".join(lines) + "\n" + table + rest


def build(path, wheels):
    """Writes a zip with these wheels. @throws ValueError, see check()."""
    check(wheels)
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        add(archive, "blender_manifest.toml", manifest(wheels).encode())
        for file in sorted((ROOT / "addon").rglob("*")):
            if file.is_file() and "__pycache__" not in file.parts:
                add(archive, file.relative_to(ROOT / "addon").as_posix(), file.read_bytes())
        for name in ("LICENSE", "NOTICE"):  # of the add-on; the wheels have the solver's
            add(archive, name, (ROOT / name).read_bytes())
        for name, content in manual_page.files().items():
            add(archive, f"manual/{name}", content)
        for wheel in sorted(wheels):
            add(archive, f"wheels/{wheel.name}", wheel.read_bytes())


def add(archive, name, content):
    """Without the time and the owner: the same sources make the same bytes."""
    entry = zipfile.ZipInfo(name)
    entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
    archive.writestr(entry, content)


def build_all(folder, wheels):
    """Writes the zips into `folder` and returns their paths. @throws ValueError, see check()."""
    check(wheels)
    for old in folder.glob("meanvalue-*-extension*.zip"):
        old.unlink()
    paths = []
    for name in sorted({platform(wheel) for wheel in wheels}):
        # Called as Blender's own tool does, and as solver/native_loader.py tells the user.
        paths.append(folder / f"meanvalue-{version()}-extension-{name.replace('-', '_')}.zip")
        build(paths[-1], [wheel for wheel in wheels if platform(wheel) == name])
    if len(paths) > 1:
        for_all = folder / f"meanvalue-{version()}-extension.zip"
        build(for_all, wheels)
        if for_all.stat().st_size > LARGEST_FOR_ALL:
            for_all.unlink()
        else:
            paths.append(for_all)
    return paths


if __name__ == "__main__":
    try:
        print(*build_all(pathlib.Path(sys.argv[1]), [pathlib.Path(name) for name in sys.argv[2:]]), sep="\n")
    except ValueError as error:
        sys.exit(f"build_extension.py: {error}")
