import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from irsim_gym.simulator.geometry.angles import TINY, nearly_arctan2, wrap, wrap_from

finite = st.floats(-1e6, 1e6)


@pytest.mark.parametrize(
    ("angle", "expected"),
    [(0.0, 0.0), (np.pi, np.pi), (-np.pi, np.pi), (1.5 * np.pi, -0.5 * np.pi), (-1.5 * np.pi, 0.5 * np.pi)],
)
def test_wrap_by_hand(angle: float, expected: float) -> None:
    assert wrap(angle) == pytest.approx(expected, abs=1e-15)


@given(finite)
def test_wrap_stays_in_the_interval_and_keeps_the_direction(angle: float) -> None:
    wrapped = wrap(angle)
    assert -np.pi < wrapped <= np.pi
    turns = (angle - wrapped) / (2.0 * np.pi)
    assert abs(turns - np.rint(turns)) < 1e-9


@given(st.floats(-3.14159, 3.14159))
def test_wrap_leaves_wrapped_angles_alone(angle: float) -> None:
    assert wrap(angle) == angle


@pytest.mark.parametrize("step", range(-6, 7))
def test_wrap_next_to_odd_multiples_of_pi(step: int) -> None:
    edge = (2 * step + 1) * np.pi
    for angle in (np.nextafter(edge, -np.inf), edge, np.nextafter(edge, np.inf)):
        assert -np.pi < wrap(angle) <= np.pi


@pytest.mark.parametrize(("angle", "low", "expected"), [
    (3.5, -np.pi, 3.5 - 2.0 * np.pi),
    (-3.5, -np.pi, 2.0 * np.pi - 3.5),
    (np.pi, -np.pi, np.pi),
    (-np.pi, -np.pi, -np.pi),
    (-0.5, 0.0, 2.0 * np.pi - 0.5),
    (2.0 * np.pi, 0.0, 2.0 * np.pi),
    (7.0, 0.0, 7.0 - 2.0 * np.pi),
])  # fmt: skip
def test_wrap_from_by_hand(angle: float, low: float, expected: float) -> None:
    assert wrap_from(angle, low) == expected


@given(finite, st.floats(-10.0, 10.0))
def test_wrap_from_stays_in_the_interval(angle: float, low: float) -> None:
    wrapped = wrap_from(angle, low)
    assert low <= wrapped <= low + 2.0 * np.pi
    turns = (angle - wrapped) / (2.0 * np.pi)
    assert abs(turns - np.rint(turns)) < 1e-9


def test_what_is_not_a_number_stays_so() -> None:
    assert np.isnan(wrap(np.nan))
    assert np.isnan(wrap_from(np.nan, 0.0))


@given(finite, finite)
def test_nearly_arctan2_is_within_its_error(y: float, x: float) -> None:
    assume(max(abs(y), abs(x)) > TINY)
    assert nearly_arctan2(y, x) == pytest.approx(np.arctan2(y, x), rel=0, abs=2e-8)


@pytest.mark.parametrize(("y", "x"), [(0, 0), (0, 1), (1, 0), (0, -1), (-1, 0), (0, 1e-300), (-1e300, 0)])
def test_nearly_arctan2_is_exact_on_the_axes(y: float, x: float) -> None:
    assert nearly_arctan2(float(y), float(x)) == np.arctan2(float(y), float(x))
