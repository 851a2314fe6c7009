# SPDX-License-Identifier: GPL-3.0-or-later
"""What a drag shows while its next answer is solved."""

import numpy as np
import pytest

from addon.solver.core.prediction import Prediction


class Body:
    """Answers linearly: the shape is a mean of the targets."""

    def __init__(self, seed=0):
        self.random = np.random.default_rng(seed)
        self.shares = self.random.dirichlet(np.ones(4), 50)  # n x k
        self.rest = self.random.normal(size=(4, 3))

    def answer(self, targets):
        return (self.shares @ targets).astype(np.float32)

    def moved(self, *shift):
        """The last target moved, the others held."""
        targets = self.rest.copy()
        targets[-1] += shift
        return targets


@pytest.fixture
def body():
    return Body()


@pytest.fixture
def told(body):
    """Of the answers at rest and at two moves."""
    found = Prediction(1.0)
    for shift in ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.1, 0.1, 0.0)):
        found.note(body.moved(*shift), body.answer(body.moved(*shift)))
    return found


@pytest.mark.parametrize("shift", [(0.2, 0.15, 0.0), (0.0, 0.0, 0.0), (0.1, 0.1, 0.0)])
def test_a_move_like_those_before_goes_on_as_they_did(body, told, shift):
    targets = body.moved(*shift)
    assert np.abs(told.at(targets) - body.answer(targets)).max() < 1e-6
    assert told.foreseen is targets


@pytest.mark.parametrize("shift", [(0.1, 0.1, 0.1), (0.1, 0.9, 0.0)], ids=["another direction", "too far"])
def test_nothing_is_foreseen_of_a_move_of_another_kind(body, told, shift):
    assert told.at(body.moved(*shift)) is None
    assert told.foreseen is None


def test_answers_in_which_some_targets_count_less_tell_nothing_of_others(body, told):
    told.note(body.moved(0.2, 0.1, 0.0), body.answer(body.rest), np.array([1.0, 1.0, 1.0, 0.2]))
    assert not told.is_ready
    for shift in ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0)):
        assert told.at(body.moved(0.2, 0.1, 0.0)) is None
        told.note(body.moved(*shift), body.answer(body.moved(*shift)))
    assert np.abs(told.at(body.moved(0.2, 0.0, 0.0)) - body.answer(body.moved(0.2, 0.0, 0.0))).max() < 1e-6


def test_one_answer_foresees_nothing(body):
    found = Prediction(1.0)
    assert found.at(body.rest) is None
    found.note(body.rest, body.answer(body.rest))
    assert found.at(body.moved(0.1, 0.0, 0.0)) is None


def test_an_answer_that_was_predicted_wrongly_ends_predictions_until_one_is_right(body, told):
    targets = body.moved(0.2, 0.1, 0.0)
    told.note(targets, body.answer(targets) + np.float32(0.1))
    assert told.at(body.moved(0.25, 0.1, 0.0)) is None
    for shift in (0.25, 0.3, 0.35):
        targets = body.moved(shift, 0.1, 0.0)
        told.note(targets, body.answer(targets) + np.float32(0.1))
    further = body.moved(0.4, 0.1, 0.0)
    assert np.abs(told.at(further) - body.answer(further) - 0.1).max() < 1e-5


def test_a_settled_answer_is_a_new_beginning(body, told):
    targets = body.moved(0.2, 0.1, 0.0)
    told.begin(targets, body.answer(targets))
    assert told.at(body.moved(0.3, 0.1, 0.0)) is None
