from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from irsim_gym.scenario.expressions import evaluate


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("pi", math.pi),
        ("-pi", -math.pi),
        ("2*pi", 2 * math.pi),
        ("-3 * pi / 4", -3 * math.pi / 4),
        ("(1 + 2) * 3", 9),
        ("1 - 2 - 3", -4),
        ("8 / 4 / 2", 1.0),
        ("2 + 3 * 4", 14),
        ("--2", 2),
        ("+(-(.5))", -0.5),
        ("1e-3", 0.001),
        ("1.", 1.0),
        ("007", 7),
    ],
)
def test_arithmetic(text: str, value: float) -> None:
    result = evaluate(text)
    assert result == pytest.approx(value, abs=0.0)
    assert type(result) is type(value)


@pytest.mark.parametrize(
    "text",
    [
        *[
            "",
            " ",
            "+",
            "1 +",
            "* 2",
            "2pi",
            "pi pi",
            "(1",
            "1)",
            "()",
            "1 / 0",
            "1e308 * 10",
            "1e999",
            "2 ** 3",
            "tau",
            "e",
        ],
        *["1_000", "abs(1)", "__import__('os')", "1;2", "1,2", "pi.real", "0x10", "٣", "1" * 81, "(" * 80, "1\n+1"],
    ],
)
def test_anything_else_is_no_number(text: str) -> None:
    assert evaluate(text) is None


@given(st.text(alphabet="0123456789.eEpi+-*/() ", max_size=90))
def test_never_fails_and_never_gives_nan(text: str) -> None:
    result = evaluate(text)
    assert result is None or math.isfinite(result)


@given(
    st.recursive(
        st.integers(0, 99).map(str),
        lambda inner: st.tuples(inner, st.sampled_from("+-*"), inner).map(
            lambda parts: f"({parts[0]}{parts[1]}{parts[2]})"
        ),
        max_leaves=6,
    )
)
def test_agrees_with_python(text: str) -> None:
    if len(text) <= 80 and not any(part.startswith("0") and len(part) > 1 for part in text.split()):
        assert evaluate(text) == eval(text)
