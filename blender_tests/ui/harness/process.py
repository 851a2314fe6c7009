# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs scenarios in a Blender of their own, watches it, and tells how each scenario ended."""

import dataclasses
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time

from support import installed

from harness.display import SIZE, Display, photograph

ROOT = pathlib.Path(__file__).resolve().parents[3]
OUTPUT = pathlib.Path(os.environ.get("MEANVALUE_UI_OUTPUT", ROOT / "build" / "ui"))
RUNNER = pathlib.Path(__file__).with_name("inside.py")
TRACEBACK = "Traceback (most recent call last)"

# Blender is killed when no scenario has come to a new step for so long. Single waits end by themselves before that.
STUCK_SECONDS = float(os.environ.get("MEANVALUE_UI_STUCK_SECONDS", "180"))
LONGEST_SECONDS = 1200.0
LOOK_SECONDS = 0.2


@dataclasses.dataclass
class Outcome:
    """How a scenario ended. `problems` is empty if it went well."""

    problems: list
    seconds: float = 0.0


def run(path, names):
    """{name: Outcome} of the scenarios `names` of the file `path`. When Blender dies, another does the rest."""
    outcomes = {}
    while left := [name for name in names if name not in outcomes]:
        ended = _Session(path, left).run()
        outcomes.update(ended or {left[0]: Outcome(["Blender told nothing about this scenario"])})
    return outcomes


class _Session:
    """One Blender process."""

    def __init__(self, path, names):
        self._path = path
        self._names = names
        OUTPUT.mkdir(parents=True, exist_ok=True)
        self._log = OUTPUT / f"{path.stem}.log"
        self._events = OUTPUT / f"{path.stem}.jsonl"
        self._events.write_text("")

    def run(self):
        options = "--factory-startup -noaudio --enable-event-simulate --python-exit-code 1 --window-geometry 0 0"
        inside = ["--", self._path, self._events, *self._names]
        with (
            tempfile.TemporaryDirectory(prefix="meanvalue-ui-") as folder,
            Display() as display,
            self._log.open("w") as log,
        ):
            environment = _environment(display, pathlib.Path(folder))
            if installed.IS_EXTENSION:
                installed.install_by_command("blender", environment)
            # A session of its own, so that all of it can be ended. stdbuf: C and Python write into one log.
            blender = subprocess.Popen(
                ["stdbuf", "-oL", "blender", *options.split(), *map(str, SIZE), "--python", RUNNER, *inside],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=environment,
                start_new_session=True,
            )
            try:
                end = self._watch(blender, display)
            finally:
                _kill(blender)
            backtraces = "".join(path.read_text() for path in pathlib.Path(folder).glob("*.crash.txt"))
        return self._outcomes(f"{end}\n{backtraces}" if end else None)

    def _watch(self, blender, display):
        """Waits for the end; what was wrong with it, or None."""
        known, since = -1, time.monotonic()
        latest = since + LONGEST_SECONDS
        while blender.poll() is None:
            size = self._events.stat().st_size
            if size != known:
                known, since = size, time.monotonic()
            if time.monotonic() > min(since + STUCK_SECONDS, latest):
                picture = OUTPUT / f"{self._path.stem}-stuck.png"
                photograph(display.file, picture)
                why = f"no new step for {STUCK_SECONDS:.0f} s, or {LONGEST_SECONDS:.0f} s in all"
                return f"Blender was ended: {why}; picture: {picture}"
            time.sleep(LOOK_SECONDS)
        if blender.returncode < 0:
            return f"Blender crashed: {signal.Signals(-blender.returncode).name}"
        return f"Blender ended with status {blender.returncode}" if blender.returncode else None

    def _outcomes(self, end):
        """A scenario that had begun when Blender ended is to blame; else the last that was finished."""
        outcomes, current, step = {}, None, "start"
        for event in map(json.loads, self._events.read_text().splitlines()):
            if "begin" in event:
                current, step = event["begin"], "begin"
            elif "step" in event:
                step = event["step"]
            elif "end" in event:
                outcomes[event["end"]] = Outcome(event["problems"], event["seconds"])
                current = None
        texts = self._output_by_scenario()
        for name, outcome in outcomes.items():
            if TRACEBACK in texts.get(name, ""):
                outcome.problems.append(f"Blender printed a traceback:\n{texts[name]}")
        if current and not end:
            end = "Blender ended before the scenario did"
        if end:
            at = f"at the step: {step}" if current else "outside of a scenario, after the step: " + step
            culprit = current or (list(outcomes) or self._names)[-1 if outcomes else 0]
            outcome = outcomes.setdefault(culprit, Outcome([]))
            outcome.problems.append(f"{end}\n{at}\nlast output:\n{texts.get(culprit, texts[''])[-4000:]}")
        return outcomes

    def _output_by_scenario(self):
        """What Blender printed, by the scenario after whose beginning it did so; "" is before the first."""
        texts, name = {"": ""}, ""
        for line in self._log.read_text(errors="replace").splitlines(keepends=True):
            if line.startswith("@@ "):
                name = line.split()[1]
                texts[name] = ""
            else:
                texts[name] += line
        return texts


def _environment(display, folder):
    """No trace of the user's Blender or Python; software drawing that is the same everywhere."""
    own = {f"BLENDER_USER_{kind}": folder / kind.lower() for kind in ("SCRIPTS", "CONFIG", "RESOURCES")}
    for path in own.values():
        path.mkdir()
    ours = {"DISPLAY": display.name, "TMPDIR": folder, "LIBGL_ALWAYS_SOFTWARE": "1", "PATH": "/usr/bin:/bin"}
    ours |= {"MEANVALUE_UI_PICTURES": OUTPUT, "MEANVALUE_UI_DISPLAY_FILE": display.file}
    return {**os.environ, **{name: str(value) for name, value in (own | ours).items()}}


def clear_output():
    """Takes away what an earlier run left in build/ui."""
    shutil.rmtree(OUTPUT, ignore_errors=True)


def _kill(blender):
    if blender.poll() is None:
        os.killpg(blender.pid, signal.SIGKILL)
    blender.wait()
