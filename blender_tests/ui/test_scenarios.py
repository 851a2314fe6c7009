# SPDX-License-Identifier: GPL-3.0-or-later
"""One test for each scenario of the files beside this one; one Blender for each file, with what is left by -k."""

import pytest
from harness import listing, process

_outcomes = {}


@pytest.fixture(scope="session", autouse=True)
def clear_output():
    process.clear_output()


@pytest.mark.parametrize(
    ("path", "name"),
    [
        pytest.param(path, name, id=f"{path.stem}-{name}")
        for path in listing.scenario_files()
        for name in listing.scenarios(path)
    ],
)
def test_scenario(path, name, request):
    if path not in _outcomes:
        _outcomes[path] = process.run(path, _chosen(request.session, path))
    outcome = _outcomes[path][name]
    print(f"{path.stem}.{name}: {outcome.seconds:.1f} s")
    if outcome.problems:
        pytest.fail("\n\n".join(outcome.problems), pytrace=False)


def _chosen(session, path):
    calls = [item.callspec.params for item in session.items if item.function is test_scenario]
    return [call["name"] for call in calls if call["path"] == path]
