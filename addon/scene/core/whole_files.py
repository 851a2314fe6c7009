# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are there whole or not at all: written under another name in the same folder, then renamed. And names of
files that every system takes, since a scene goes from one to another."""

import contextlib
import errno
import glob
import os
import pathlib
import re
import secrets
import time

from ...errors import CacheError

#: What nothing has been written to for so long was left by a process that was killed.
ABANDONED_SECONDS = 3600.0

#: How long the renaming of a file waits, in seconds: Windows refuses it while another program has either file open, one
#: that looks for viruses, or Blender playing a cache. That is over soon.
RETRIES = (0.05, 0.1, 0.2, 0.4, 0.8)

_FULL = {errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC), errno.EFBIG}
_PROTECTED = {errno.EACCES, errno.EPERM, errno.EROFS}


@contextlib.contextmanager
def replacing(path):
    """Context manager of a binary file, open for writing and reading, that becomes `path` when all went well; else what
    was begun is taken away. The folder is made if it is missing. @throws CacheError in place of OSError."""
    path = pathlib.Path(path)
    with telling(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        remove_abandoned(path)
        begun = path.with_name(f"{path.name}.tmp.{secrets.token_hex(4)}")  # others may write the same
        try:
            with begun.open("w+b") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            rename(begun, path)
        except BaseException:
            with contextlib.suppress(OSError):
                begun.unlink()
            raise


def rename(begun, path):
    """Has what was written as `begun` be `path`. @throws OSError."""
    for seconds in RETRIES:
        with contextlib.suppress(PermissionError):
            begun.replace(path)
            return
        time.sleep(seconds)
    begun.replace(path)


def require_place(path):
    """Where `path` is to be written there is a folder to write to, or to make it in; looks only. @throws CacheError."""
    path = pathlib.Path(path)
    with telling(path):
        folder = next((each for each in path.parents if each.exists()), path.parent)
        os.scandir(folder).close()  # the system says what is wrong
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        with contextlib.suppress(FileNotFoundError):
            path.stat()  # as it does where a name is too long


@contextlib.contextmanager
def telling(path):
    """Inside, an OSError becomes a CacheError that says what to do."""
    try:
        yield
    except OSError as error:
        raise CacheError(_explanation(pathlib.Path(path), error)) from error


def remove_abandoned(path):
    """Takes away what killed processes have left of `path`."""
    for left in path.parent.glob(f"{glob.escape(path.name)}.tmp.*"):
        with contextlib.suppress(OSError):
            if time.time() - left.stat().st_mtime > ABANDONED_SECONDS:
                left.unlink()


def _explanation(path, error):
    if error.errno in _FULL:
        return f"The disk is full: '{path.name}' does not fit into {path.parent}. Make room and bake again, to go on"
    if error.errno in _PROTECTED:
        refused = f"'{path.name}' may not be written to {path.parent} ({error.strerror})"
        return f"{refused}, or another program has it open. Close that, or choose another path"
    if error.errno in {errno.ENOENT, errno.ENOTDIR}:
        return f"'{path}' cannot be reached ({error.strerror}). Choose another path, or connect the drive"
    return f"'{path}' cannot be read or written ({error.strerror or error}). Choose another path"


def in_bytes(count):
    """`in_bytes(1234567)` is "1.2 MB"."""
    for unit in ("bytes", "KB", "MB"):
        if count < 1000:
            return f"{count:.0f} {unit}" if unit == "bytes" or count >= 100 else f"{count:.1f} {unit}"
        count /= 1000
    return f"{count:,.1f} GB"


#: With any ending Windows takes them for devices.
_DEVICE = re.compile(r"^(con|prn|aux|nul|com[0-9¹²³]|lpt[0-9¹²³])(?=\.|$)", re.IGNORECASE)
_REFUSED = re.compile(r'[<>:"/\\|?*\x00-\x1f]')


def file_name(name):
    """`name` of an object or a clip, without an ending, as that of a file or folder."""
    return _DEVICE.sub(r"\1_", _REFUSED.sub("_", name).rstrip(". ")) or "_"
