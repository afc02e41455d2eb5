"""Every public name says what goes in and out: parameters, shapes of arrays, units of numbers, errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from builder import reference
from reference_rules import Documented, documented, unnamed, unsaid_errors, without_shape, without_unit

from irsim_gym.base.arraytypes import Floats
from irsim_gym.simulator.world.model import Model

NAMES = [one for one in documented() if not one.is_of_others]


@pytest.mark.parametrize("rule", [unnamed, without_shape, without_unit, unsaid_errors])
def test_docstrings_say_what_goes_in_and_out(rule: Callable[[Documented], Iterator[str]]) -> None:
    assert len(NAMES) > 300
    assert [fault for one in NAMES for fault in rule(one)] == []


def test_arrays_that_declare_themselves_are_a_table_with_shapes_and_units() -> None:
    page = reference.pages()["reference/plugins.rst"].split("autoclass:: irsim_gym.plugins.Model")[1]
    table = page.split(".. auto")[0]
    assert table.count("      * - ") == len(Model.columns()) + 1
    row = ["* - goal\\_threshold", "- (world\\*, body)", "- float64", "- m", "- distance under which a goal is reached"]
    assert "\n".join(line.strip() for line in table.splitlines()).count("\n".join(row)) == 1


def speed(wheel: float, turns: Floats) -> Floats:
    """Return how fast it drives."""
    if wheel < 0.0:
        raise ValueError("a wheel has a radius above 0")
    return wheel * turns


def brake(force: float, turns: Floats) -> float:
    """Return how long it takes.

    Args:
        force: How hard it brakes.
        turns: How fast the wheels turn [rad/s].
    """
    return float(np.max(turns) / force)


def drift(force: float, turns: Floats) -> Floats:
    """Return how far it drifts [m], ``(n,)``.

    Args:
        force: Force on the ``wheels`` [N]: it
            acts at once.
        turns: Turn rates [rad/s], shape ``(n,)``.

    Raises:
        ValueError: There is no force.
    """
    if force == 0.0:
        raise ValueError("there is no force")
    return force * turns


@pytest.mark.parametrize(
    ("rule", "faults"),
    [
        (unnamed, ["speed: wheel", "speed: turns"]),
        (without_shape, ["speed: what it returns", "brake: turns"]),
        (without_unit, ["brake: force", "brake: what it returns"]),
        (unsaid_errors, ["speed: ValueError"]),
    ],
)
def test_the_rules_see_what_is_missing(rule: Callable[[Documented], Iterator[str]], faults: list[str]) -> None:
    mine = [Documented(function.__name__, function) for function in (speed, brake, drift)]
    assert [fault for one in mine for fault in rule(one)] == faults
