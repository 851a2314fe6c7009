# SPDX-License-Identifier: GPL-3.0-or-later
"""Another Debian in a folder, to run programs of that release on this system. Needs root.

Mounts are made in a namespace of the process that runs, so they end with it, however it ends.
"""

import os
import pathlib
import shlex
import shutil
import subprocess

MOUNTS = """
set -e
mount -t proc proc "$CHROOT/proc"
mount --rbind /dev "$CHROOT/dev"
mount -t tmpfs tmpfs "$CHROOT/tmp"
for folder in "$@"; do
  mkdir -p "$CHROOT$folder"
  mount --bind "$folder" "$CHROOT$folder"
done
"""


class UnavailableError(Exception):
    """Such a Debian can't be had here; the message says why."""


def mirror():
    """Where this machine gets its Debian from."""
    wanted = ["apt-get", "indextargets", "--format", "$(REPO_URI)", "Created-By: Packages", "Label: Debian"]
    found = subprocess.run(wanted, capture_output=True, text=True).stdout.split()
    if not found:
        raise UnavailableError("apt knows no source of Debian's packages")
    return found[0].rstrip("/")


class Chroot:
    def __init__(self, folder):
        """`folder` is made by make() and reused; remove it to have a newer state of the release."""
        self._folder = pathlib.Path(folder).resolve()

    def make(self, suite, packages, processor=None):
        """With `packages` and what they need, unless it was made with the same before.

        For another `processor`, as Debian calls it, all is only unpacked, for an emulator that is given the folder.
        @throws UnavailableError.
        """
        made, wanted = self._folder.with_suffix(".made"), " ".join([suite, *packages])
        if os.geteuid() != 0 and not processor:
            raise UnavailableError(f"a chroot with Debian {suite} is made and entered by root")
        if made.exists() and made.read_text() == wanted:
            return
        made.unlink(missing_ok=True)
        if self._folder.exists():
            shutil.rmtree(self._folder)
        log = self._folder.with_suffix(".log")
        options = ["--components=main", f"--include={','.join(packages)}"]
        options += ["--variant=extract", f"--architectures={processor}"] if processor else ["--variant=minbase"]
        # The archive that is mirrored here may lag behind this machine's clock; it is signed all the same.
        settings = ('APT::Install-Recommends "false"', 'Acquire::Check-Valid-Until "false"')
        options += [f"--aptopt={setting}" for setting in settings]
        with log.open("w") as output:
            done = subprocess.run(
                ["mmdebstrap", *options, suite, str(self._folder), f"deb {mirror()} {suite} main"],
                stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
            )  # fmt: skip
        if done.returncode:
            raise UnavailableError(f"no chroot with Debian {suite} could be made: {_last_error(log)}; see {log}")
        made.write_text(wanted)

    def run(self, command, folders, environment, **options):
        """subprocess.run() of `command` in there, with this system's `folders` at their own paths, in the first."""
        enter = shlex.join(["chroot", str(self._folder), "env", "-i", "-C", str(folders[0])])
        variables = {"PATH": "/usr/bin:/bin:/usr/sbin:/sbin", "HOME": "/root", "LANG": "C.UTF-8", **environment}
        entered = f"exec {enter} {shlex.join([f'{name}={value}' for name, value in variables.items()])} "
        return subprocess.run(
            ["unshare", "--mount", "--pid", "--fork", "--kill-child", "bash", "-c",
             MOUNTS + entered + shlex.join(map(str, command)), "mounts", *map(str, folders)],
            env={**os.environ, "CHROOT": str(self._folder)}, **options,
        )  # fmt: skip


def _last_error(log):
    errors = [line for line in log.read_text().splitlines() if line.startswith("E: ")]
    return errors[0][3:] if errors else "mmdebstrap failed"
