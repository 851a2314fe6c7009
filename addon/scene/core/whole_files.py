# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are there whole or not at all: written under another name in the same folder, then renamed."""

import contextlib
import errno
import os
import pathlib
import shutil
import socket
import time

from ...errors import CacheError

#: What other machines left of files that were never finished is taken away after so long.
ABANDONED_SECONDS = 24 * 3600.0

#: How long the renaming of a file waits for other programs, in seconds.
RETRIES = (0.05, 0.1, 0.2, 0.4, 0.8)
#: What Windows says then: access denied, sharing violation.
_OPEN_ELSEWHERE = {5, 32}

_FULL = {errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC), errno.EFBIG}
_PROTECTED = {errno.EACCES, errno.EPERM, errno.EROFS}


@contextlib.contextmanager
def replacing(path, byte_count=0):
    """Context manager of a binary file, open for writing and reading, that becomes `path` when all went well.

    byte_count: how much will be written, for the message where the disk is full. The folder is made if it is missing.
    Whatever happens, there is the old file or the new one, and what was begun is taken away.

    @throws CacheError in place of OSError.
    """
    path = pathlib.Path(path)
    with telling(path, byte_count):
        path.parent.mkdir(parents=True, exist_ok=True)
        remove_abandoned(path)
        begun = path.with_name(f"{path.name}.tmp.{socket.gethostname()}.{os.getpid()}")
        try:
            with begun.open("w+b") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            _rename(begun, path)
        except BaseException:
            with contextlib.suppress(OSError):
                begun.unlink()
            raise
        _sync_folder(path.parent)


def _rename(begun, path):
    """Windows refuses it while another program has either file open: one that looks for viruses, or Blender playing a
    cache, which is over soon."""
    for seconds in RETRIES:
        try:
            begun.replace(path)
            return
        except OSError as error:
            if getattr(error, "winerror", None) not in _OPEN_ELSEWHERE:
                raise
            time.sleep(seconds)
    begun.replace(path)


def require_place(path):
    """Where `path` is to be written there is a folder to write to, or to make it in; looks only.

    @throws CacheError.
    """
    path = pathlib.Path(path)
    with telling(path):
        folder = next((each for each in path.parents if each.exists()), None)
        if folder is None:
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
        if not folder.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        with contextlib.suppress(FileNotFoundError):
            path.stat()  # the system says so where a name is too long


@contextlib.contextmanager
def telling(path, byte_count=0):
    """Inside, an OSError becomes a CacheError that says what to do."""
    try:
        yield
    except OSError as error:
        raise CacheError(_explanation(pathlib.Path(path), error, byte_count)) from error


def remove_abandoned(path):
    """Takes away what killed processes have left of `path`: those of this machine, and old ones of others."""
    mark = f"{path.name}.tmp."
    for left in path.parent.glob("*.tmp.*"):
        if left.name.startswith(mark) and _is_abandoned(left, left.name[len(mark) :]):
            with contextlib.suppress(OSError):
                left.unlink()


def _is_abandoned(path, host_and_process):
    host, _, process = host_and_process.rpartition(".")
    with contextlib.suppress(OSError):
        if host != socket.gethostname() or os.name != "posix" or not process.isdigit():
            return time.time() - path.stat().st_mtime > ABANDONED_SECONDS
        try:
            os.kill(int(process), 0)
        except ProcessLookupError:
            return True
    return False


def _sync_folder(folder):
    """So that the new name survives a power failure. Windows cannot, and need not."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _explanation(path, error, byte_count):
    if error.errno in _FULL:
        needed = f", {in_bytes(byte_count)} are needed" if byte_count else ""
        return (
            f"The disk is full: '{path.name}' does not fit into {path.parent} ({_free(path.parent)}{needed}). Make "
            "room or choose another path, and bake again: it goes on from what is done"
        )
    if getattr(error, "winerror", None) in _OPEN_ELSEWHERE:
        return (
            f"'{path.name}' in {path.parent} may not be written: another program has it open, or it is protected. "
            "Close that program, or choose another path"
        )
    if error.errno in _PROTECTED:
        return f"'{path.name}' may not be written to {path.parent} ({error.strerror}). Choose another path"
    if error.errno in {errno.ENOENT, errno.ENOTDIR}:
        return f"'{path}' cannot be reached ({error.strerror}). Choose another path, or connect the drive"
    return f"'{path}' cannot be read or written ({error.strerror or error}). Choose another path"


def _free(folder):
    try:
        return f"{in_bytes(shutil.disk_usage(folder).free)} are free"
    except OSError:
        return "nothing is free"


def in_bytes(count):
    """`in_bytes(1234567)` is "1.2 MB"."""
    for unit in ("bytes", "KB", "MB"):
        if count < 1000:
            return f"{count:.0f} {unit}" if unit == "bytes" or count >= 100 else f"{count:.1f} {unit}"
        count /= 1000
    return f"{count:,.1f} GB"
