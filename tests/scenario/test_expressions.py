from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from irsim_gym.scenario.text.expressions import evaluate, names_in


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
        ("min(3, 2*2, 5)", 3),
        ("-max(1, (2), 0.5) * 3", -6),
        ("floor(7 / 2) + floor(-0.5)", 2),
        ("max(min(1, 2), 0.5)", 1),
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
        *[
            "1_000",
            "abs(1)",
            "__import__('os')",
            "1;2",
            "1,2",
            "pi.real",
            "0x10",
            "٣",
            "min",
            "min 1",
            "min(1)",
            "min()",
            "min(1,)",
            "max(,1)",
            "floor(1, 2)",
            "(1, 2)",
            "min(1, 2",
            "$n",
            "$",
            "1" * 81,
            "(" * 80,
            "1\n+1",
        ],
    ],
)
def test_anything_else_is_no_number(text: str) -> None:
    assert evaluate(text) is None


@pytest.mark.parametrize(
    ("text", "value"), [("$n", 4), ("2*$n - $half", 7.5), ("max($n,10)", 10), ("floor($half)", 0), ("-$n/8", -0.5)]
)
def test_names_stand_for_given_values(text: str, value: float) -> None:
    result = evaluate(text, {"n": 4, "half": 0.5})
    assert result == value
    assert type(result) is type(value)
    assert evaluate(text, {}) is None


def test_names_of_an_expression() -> None:
    assert names_in("2 * $n + min($m_2, pi)") == ("n", "m_2")
    assert [names_in(text) for text in ("2 * pi", "robot $n", "$n$", "${n}", "$2")] == [()] * 5


@given(st.text(alphabet="0123456789.eEpi+-*/(), mnaxflor$", max_size=90))
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
