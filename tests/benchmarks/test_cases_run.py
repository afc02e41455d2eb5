"""Every case of the benchmarks runs, with one step of the smallest size; no time is looked at."""

from __future__ import annotations

import json
import math
import runpy
import sys
from pathlib import Path
from typing import Any

import c_twin
import catalogue
import numpy as np
import pytest
import results
from catalogue import CASES, LONG
from effort import TINY, Effort, flatten
from jsonschema import Draft202012Validator
from phases import Stopwatch, places, use_plain_path, watching
from players import Player
from standard_worlds import s1, s4
from timing import Timing, off

from irsim_gym.envs.gymnasium.worlds import Worlds

UNITS = (
    *("_us", "_ms", "_s", "_kib", "_kernels", "_steps", "_worlds"),
    *("_share", "_share_of_noop", "_times_faster", "_times_slower", "_over_twin", "_over_plain"),
)
ROOT = Path(__file__).parents[2]


def valid(result: dict[str, Any]) -> None:
    Draft202012Validator(json.loads(results.SCHEMA.read_text(encoding="utf-8"))).validate(result)


HEAVY = {"memory"}
"""Cases that make so many worlds that they take seconds."""


@pytest.mark.parametrize("name", sorted(CASES.keys() - LONG - HEAVY))
def test_a_case_runs(name: str) -> None:
    figures = list(flatten(CASES[name](TINY)))
    assert figures or (name == "s1/twin" and c_twin.compiler() is None)
    for figure, value, _ in figures:
        assert figure.endswith(UNITS), figure
        assert math.isfinite(value), figure


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(LONG | HEAVY))
def test_a_long_case_runs(name: str) -> None:
    assert all(math.isfinite(value) for _, value, _ in flatten(CASES[name](TINY)))


def test_the_command_writes_a_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "result.json"
    arguments = ["run.py", "--tiny", "-f", "^s2/", "--json", str(file)]
    monkeypatch.setattr(sys, "argv", arguments)
    assert run() == 0
    result = results.read(file)
    valid(result)
    assert set(result["results"]) == set(result["took_s"]) == {"s2/rvo", "s2/orca"}


def test_a_case_that_fails_does_not_keep_the_others_from_running(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(effort: Effort) -> dict[str, float]:
        raise ValueError(str(effort))

    monkeypatch.setattr(catalogue, "CASES", {"bad": fail, "good": lambda effort: {"x_us": 2.0}})
    file = tmp_path / "result.json"
    monkeypatch.setattr(sys, "argv", ["run.py", "--json", str(file)])
    assert run() == 1
    assert results.read(file)["results"] == {"good": {"x_us": 2.0}}


def run() -> object:
    with pytest.raises(SystemExit) as caught:
        runpy.run_path(str(ROOT / "benchmarks" / "run.py"), run_name="__main__")
    return caught.value.code


@pytest.mark.parametrize("file", sorted(results.FOLDER.glob("*.json")), ids=lambda file: file.name)
def test_committed_results_follow_the_schema(file: Path) -> None:
    valid(results.read(file))


def test_sizes_above_the_largest_are_left_out() -> None:
    effort = Effort(rounds=1, round_s=0.0, largest=40)
    assert effort.sizes((10, 30, 100)) == [10, 30]
    assert effort.sizes((100, 200)) == [100]


def test_noise_is_how_far_the_median_lies_above_the_least() -> None:
    timing = Timing(least=2.0, median=2.5, rounds=3)
    assert timing.noise == 0.25
    assert timing.times(4.0) == Timing(8.0, 10.0, 3)


def test_a_round_is_judged_by_what_is_usual() -> None:
    assert off([1.0, 1.5, 1.0, 0.5, 1.0]) == [0.0, 0.5, 0.0, 1.0, 0.0]
    assert off([]) == []


def test_an_outer_phase_counts_as_a_whole() -> None:
    watch = Stopwatch()
    inner = watch.around("inner", lambda: None)
    watch.around("outer", inner)()
    assert watch.calls == {"outer": 1}
    inner()
    assert watch.calls == {"outer": 1, "inner": 1}


def test_wrappers_of_the_phases_are_taken_off_again() -> None:
    worlds = Worlds(s4(2, 2), 1, team=True)
    owners = [(owner, name, vars(owner).get(name)) for _, owner, name in places(worlds)]
    with watching(worlds, Stopwatch()):
        assert all(vars(owner).get(name) is not before for owner, name, before in owners)
    assert all(vars(owner).get(name) is before for owner, name, before in owners)


def test_on_the_plain_path_a_step_goes_through_every_phase() -> None:
    worlds, watch = Worlds(s4(2, 2), 1, team=True), Stopwatch()
    worlds.begin([0], [0], [{}], lambda w: w)
    use_plain_path(worlds)
    with watching(worlds, watch):
        worlds.step(np.zeros((1, 2, 2), np.float32))
    assert {"act", "decide", "move", "sense", "contact", "clearance", "count", "pay", "observe"} <= watch.calls.keys()


def test_more_obstacles_keep_their_density() -> None:
    few, many = s1(10), s1(640)
    assert (len(few["obstacle"]), len(many["obstacle"])) == (11, 641)
    assert (few["world"]["width"], many["world"]["width"]) == (10.0, 80.0)


def test_runs_begin_at_the_start_and_take_turns() -> None:
    told: list[str] = []
    pair = {
        "runs": Player(lambda: told.append("a"), 2, rewind=lambda: told.append("start"), n_steps=3),
        "goes on": Player(lambda: told.append("b"), 1),
    }
    timings = Effort(rounds=2, round_s=1e-9).in_turns_us(pair)
    # Finding the sizes takes a first step and a run of the one, and two steps of the other.
    assert "".join(told).removeprefix("start").startswith("a" + "startaaa" + "bb")
    assert "".join(told).endswith(2 * ("startaaa" + "b"))
    assert {name: timing.rounds for name, timing in timings.items()} == {"runs": 2, "goes on": 2}
