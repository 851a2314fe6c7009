#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a compiled module needs and shows, as its file says. Needs `lief`.

    check_binary.py MODULE             fails unless it needs Python and the system and shows PyInit_meanvalue, all alone
    check_binary.py --exports LIBRARY  what a library shows, a name a line
"""

import fnmatch
import sys

import lief
from wheel_targets import GLIBC

ENTRY = "PyInit_meanvalue"
#: Libraries that are on every system, by format of file. Windows 10 and later have the C runtime.
LIBRARIES = {
    lief.Binary.FORMATS.ELF: (
        "libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1", "ld-linux-x86-64.so.2",
        "ld-linux-aarch64.so.1",
    ),
    lief.Binary.FORMATS.PE: ("python3??.dll", "KERNEL32.dll", "api-ms-win-crt-*.dll"),
    lief.Binary.FORMATS.MACHO: ("/usr/lib/libSystem.B.dylib",),
}  # fmt: skip
#: What a module may show besides, as it does no harm: on Windows, where nobody looks for a name in another library than
#: the one he asks, pybind11's exceptions; on macOS the library's own header, by Zig's linker, C++'s operators new and
#: delete, and on Intel types of exceptions: as own_symbols.py leaves it, nothing takes them in place of its own.
HARMLESS = {
    lief.Binary.FORMATS.ELF: (),
    lief.Binary.FORMATS.PE: ("_Z*8pybind11*",),
    lief.Binary.FORMATS.MACHO: ("_mh_dylib_header", "__dso_handle", "_Zn*", "_Zd*", "_ZT[IS]*"),
}


def is_one_of(name, patterns):
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)


def libraries(binary):
    if binary.format == lief.Binary.FORMATS.MACHO:
        # The first is what the module calls itself.
        return [found.name for found in binary.libraries if found.command != lief.MachO.LoadCommand.TYPE.ID_DYLIB]
    return list(binary.libraries)


def exports(binary):
    if binary.format == lief.Binary.FORMATS.PE:
        return [entry.name for entry in binary.get_export().entries]
    if binary.format == lief.Binary.FORMATS.MACHO:
        return [symbol.name.removeprefix("_") for symbol in binary.exported_symbols]
    return [symbol.name for symbol in binary.exported_symbols]


def unknown(binary):
    """Names that are looked for when the module is loaded, in no library that it tells, and are not Python's."""
    if binary.format == lief.Binary.FORMATS.PE:
        return []
    if binary.format == lief.Binary.FORMATS.MACHO:
        names = [
            found.symbol.name.removeprefix("_")
            for found in binary.bindings
            if found.has_symbol and not found.has_library
        ]
    else:
        names = [
            found.name
            for found in binary.imported_symbols
            if not found.symbol_version.has_auxiliary_version and found.binding != lief.ELF.Symbol.BINDING.WEAK
        ]
    return [name for name in names if not is_one_of(name, ("Py*", "_Py*"))]


def too_new(binary):
    """Versions of glibc's symbols that it needs and that GLIBC does not have."""
    if binary.format != lief.Binary.FORMATS.ELF:
        return []
    needed = {
        version.name
        for requirement in binary.symbols_version_requirement
        for version in requirement.get_auxiliary_symbols()
    }
    versions = {name: name.removeprefix("GLIBC_") for name in needed if name.startswith("GLIBC_")}
    return sorted(name for name, version in versions.items() if number(version) > number(GLIBC))


def number(version):
    """For comparing; what has no digits, as PRIVATE, is the newest."""
    return tuple(int(part) if part.isdigit() else sys.maxsize for part in version.split("."))


def is_for_arm(binary):
    return binary.header.cpu_type == lief.MachO.Header.CPU_TYPE.ARM64


def problems(binary):
    """A line for each thing that would keep the module from working elsewhere."""
    found = [
        f"it needs {name}, which is not on every system"
        for name in libraries(binary)
        if not is_one_of(name, LIBRARIES[binary.format])
    ]
    shown = {name for name in exports(binary) if not is_one_of(name, HARMLESS[binary.format])}
    if shown != {ENTRY}:
        found.append(f"it shows {', '.join(sorted(shown)[:10]) or 'nothing'}, not {ENTRY} alone")
    found += [f"it needs {name}, newer than {GLIBC}" for name in too_new(binary)]
    found += [f"nobody has {name}, which it needs" for name in unknown(binary)]
    if binary.format == lief.Binary.FORMATS.MACHO and is_for_arm(binary) and not binary.has_code_signature:
        found.append("it is not signed, and macOS on ARM loads no such file")
    return found


def main(arguments):
    *option, path = arguments
    lief.logging.disable()
    binary = lief.parse(path)
    if binary is None:
        sys.exit(f"{path}: not a library of Linux, macOS or Windows")
    if option == ["--exports"]:
        print("\n".join(exports(binary)))
    elif found := problems(binary):
        sys.exit("\n".join(f"{path}: {problem}" for problem in found))


if __name__ == "__main__":
    main(sys.argv[1:])
