# SPDX-License-Identifier: MPL-2.0
"""What the peers' Python processes share: the loop over the steps of a job, timed."""

import pathlib
import time

from native.benchmarks.peers import job as jobs


def serve(folder, bind):
    """Works off the job in `folder`.

    bind(job) -> step(targets, restart), which gives the (n, 3) positions, or copies of them if they are kept. A step
    may have an attribute `after`: after() is called once the clock has stopped and adds to the result.
    """
    folder = pathlib.Path(folder)
    job = jobs.read(folder)
    started, cpu_started = time.perf_counter(), time.process_time()
    step = bind(job)
    result = {"bind_seconds": time.perf_counter() - started, "bind_cpu_seconds": time.process_time() - cpu_started}
    result.update({"seconds": [], "cpu_seconds": []})
    shapes, spent = [], 0.0
    for number, plan in enumerate(job.plan):
        if spent > job.options.get("frame_seconds", float("inf")) and number >= job.options.get("least_steps", 1):
            break
        targets = jobs.read_targets(folder, number, len(job.anchors))
        started, cpu_started = time.perf_counter(), time.process_time()
        positions = step(targets, bool(plan & jobs.RESTART))
        result["seconds"].append(time.perf_counter() - started)
        result["cpu_seconds"].append(time.process_time() - cpu_started)
        spent += result["seconds"][-1]
        if plan & jobs.KEEP:
            shapes.append(positions.copy())
    result["peak_bytes"] = peak_bytes()
    if hasattr(step, "after"):
        result.update(step.after())
    jobs.write_result(folder, result, shapes)


def peak_bytes():
    """The most memory this process ever held (VmHWM), with interpreter and libraries."""
    for line in pathlib.Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return 1024 * int(line.split()[1])
    return 0
