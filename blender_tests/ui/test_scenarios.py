# SPDX-License-Identifier: GPL-3.0-or-later
"""One test for each scenario of the files beside this one; one Blender for each file, with what is left by -k."""

from concurrent.futures import ThreadPoolExecutor

import pytest
from harness import listing, process

#: Blenders, each on a display of its own: a scenario waits for redraws and timers more than it computes.
AT_ONCE = 2

#: Files that `./dev test --quick` runs.
QUICK = {"first_look"}


@pytest.fixture(scope="session")
def runs(request):
    """{path: future of its outcomes}. Those with the most scenarios begin first."""
    process.clear_output()
    chosen = {}
    for item in request.session.items:
        if item.function is test_scenario:
            chosen.setdefault(item.callspec.params["path"], []).append(item.callspec.params["name"])
    with ThreadPoolExecutor(AT_ONCE) as pool:
        yield {
            path: pool.submit(process.run, path, chosen[path])
            for path in sorted(chosen, key=lambda path: len(chosen[path]), reverse=True)
        }


@pytest.mark.parametrize(
    ("path", "name"),
    [
        pytest.param(path, name, id=f"{path.stem}-{name}", marks=() if path.stem in QUICK else pytest.mark.slow)
        for path in listing.scenario_files()
        for name in listing.scenarios(path)
    ],
)
def test_scenario(path, name, runs):
    outcome = runs[path].result()[name]
    print(f"{path.stem}.{name}: {outcome.seconds:.1f} s")
    if outcome.problems:
        pytest.fail("\n\n".join(outcome.problems), pytrace=False)
