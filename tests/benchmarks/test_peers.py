"""The comparison with others: who they are, what they do not do, and how rounds are counted. No peer is installed."""

from __future__ import annotations

import argparse
import contextlib
import io
import itertools
import json
import subprocess
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import irsim_peer
import numpy as np
import peers
import processes
import pytest
import results
import standard_worlds
import worker
from jsonschema import Draft202012Validator
from peers import REQUIREMENTS, WORKS, figures_of
from processes import Player

from irsim_gym.envs.gymnasium.worlds import Worlds

PEERS = sorted(REQUIREMENTS)
OTHERS = [name for name in PEERS if name != "ours"]


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Hold back ir-sim's warnings and what it prints."""
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        yield


class Scripted:
    """A process whose rounds are known beforehand: microseconds, and seconds of the calibration."""

    def __init__(self, rounds: list[tuple[float, float]]) -> None:
        self._rounds = itertools.cycle(rounds)
        self.asked = 0

    def play(self) -> dict[str, Any]:
        self.asked += 1
        us, calibration_s = next(self._rounds)
        return {"us": us, "calibration_s": calibration_s}


def scripted(name: str, rounds: list[tuple[float, float]], monkeypatch: pytest.MonkeyPatch) -> tuple[Player, Scripted]:
    script = Scripted(rounds)
    player = Player(name, process=None)  # type: ignore[arg-type]
    monkeypatch.setattr(player, "play", script.play)
    return player, script


@pytest.mark.parametrize("name", PEERS)
def test_a_peer_describes_itself_without_its_package(name: str) -> None:
    # -I hides the folders of installed packages' users and PYTHONPATH; -S hides installed packages.
    folders = [str(peers.HERE), str(peers.HERE / "peers")]
    code = f"import sys; sys.path[:0] = {folders!r}; import {name}_peer as peer; import json; print(json.dumps("
    command = [sys.executable, "-I", "-S", "-c", code + "peer.PEER.about()))"]
    said = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    assert said["package"]
    assert {way.partition("@")[0] for way in said["works"]} <= WORKS.keys()


@pytest.mark.parametrize("name", OTHERS)
def test_a_peer_says_what_it_does_not_do(name: str) -> None:
    assert all(said for said in peers.about(name)["works"].values())


def test_we_play_every_work() -> None:
    assert {way.partition("@")[0] for way in peers.about("ours")["works"]} == WORKS.keys()


@pytest.mark.parametrize("name", OTHERS)
def test_a_peer_is_pinned(name: str) -> None:
    assert "==" in REQUIREMENTS[name][0]


def test_a_peer_that_cannot_be_installed_is_an_error_that_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(REQUIREMENTS, "irsim", (str(tmp_path / "no_such_wheel.whl"),))
    with pytest.raises(subprocess.CalledProcessError) as caught:
        peers.python_of("irsim", tmp_path, ["--no-index"])
    assert "no_such_wheel" in caught.value.stderr


def test_ours_plays_in_a_process_of_its_own() -> None:
    asked = argparse.Namespace(round_s=0.0, rounds=1, tiny=True)
    (player,) = peers.measure("s2_orca", {"ours": Path(sys.executable)}, {"ours": ["s2_orca"]}, asked)
    assert player.failure == ""
    assert len(player.values) == 1
    assert player.version


def test_a_process_that_dies_is_reported(tmp_path: Path) -> None:
    asked = argparse.Namespace(round_s=0.0, rounds=1, tiny=True)
    (player,) = peers.measure("s2_orca", {"ours": Path(sys.executable)}, {"ours": ["s2_orca@nowhere"]}, asked)
    assert "s2_orca@nowhere" in player.failure
    assert player.values == []


def test_rounds_take_turns_until_all_have_enough_good_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    calm, _ = scripted("calm", [(2.0, 1.0)], monkeypatch)
    shaken, script = scripted("shaken", [(3.0, 2.0), (9.0, 3.0), (4.0, 2.25), (5.0, 2.0)], monkeypatch)
    processes.take_turns([calm, shaken], 3)
    assert calm.values == [2.0, 2.0, 2.0]
    assert calm.counts() == {"played": 3, "rejected": 0, "disturbed": 0, "calibration_us": 1e6}
    assert (shaken.values, script.asked) == ([3.0, 4.0, 5.0], 4)
    assert shaken.counts() == {"played": 4, "rejected": 1, "disturbed": 0, "calibration_us": 2.125e6}


def test_who_is_always_disturbed_keeps_the_least_disturbed_rounds_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "RETRIES", 1)
    shaken, script = scripted("shaken", [(9.0, 0.1), (3.0, 1.0), (4.0, 1.5), (6.0, 2.0), (7.0, 0.2)], monkeypatch)
    processes.take_turns([shaken], 3)
    # Of the first four the median is 1.25: the second and the third are nearest, and one of them is good.
    assert (shaken.values, script.asked) == ([3.0, 4.0, 6.0], 4)
    assert shaken.counts() == {"played": 4, "rejected": 1, "disturbed": 1, "calibration_us": 1.25e6}


def test_how_much_slower_is_a_ratio_of_medians() -> None:
    players = [
        Player("ours", None, rounds=[(1.0, 1.0), (2.0, 1.1), (4.0, 1.0)], wanted=3),  # type: ignore[arg-type]
        Player("irsim", None, rounds=[(100.0, 1.0), (300.0, 1.0), (200.0, 1.0)], wanted=3),  # type: ignore[arg-type]
        Player("vmas", None, failure="it said nothing"),  # type: ignore[arg-type]
    ]
    figures, noise = figures_of(players)
    assert figures == {
        "ours_us": 1.0,
        "ours_median_us": 2.0,
        "irsim_us": 100.0,
        "irsim_median_us": 200.0,
        "irsim_times_slower": 100.0,
    }
    assert noise["ours_us"] == 1.0


def test_where_agents_end_is_compared_with_ours() -> None:
    players = [
        Player("ours", None, poses=[[0.0, 0.0], [1.0, 2.0]]),  # type: ignore[arg-type]
        Player("ours_batch", None, poses=[[9.0, 0.0], [1.0, 2.0]]),  # type: ignore[arg-type]
        Player("irsim", None, poses=[[0.0, 0.0], [4.0, 6.0]]),  # type: ignore[arg-type]
        Player("vmas", None),  # type: ignore[arg-type]
    ]
    assert peers.apart_m(players) == {"irsim": 5.0}


def test_starts_of_a_work_are_free_places() -> None:
    scenario = standard_worlds.s1()
    starts = peers.starts_of(scenario)
    assert len(starts) == peers.N_STARTS
    for x, y, _, goal_x, goal_y in starts:
        assert min(x, y, 10.0 - x, 10.0 - y) >= 0.3
        assert (goal_x - x) ** 2 + (goal_y - y) ** 2 >= 16.0
    assert peers.starts_of(standard_worlds.s2("rvo")) == []


def test_levels_of_a_team_have_a_place_for_each_body() -> None:
    levels = np.array(peers.levels_of(standard_worlds.s4()))
    assert levels.shape == (peers.N_LEVELS, 20, 3)
    assert (np.abs(levels[:, :, :2] - 6.0) <= 5.5).all()
    apart = np.linalg.norm(levels[:, :, None, :2] - levels[:, None, :, :2], axis=-1)[:, *np.triu_indices(20, 1)]
    assert apart.min() > 0.4
    assert peers.levels_of(standard_worlds.s1()) == []


def test_a_result_follows_the_schema() -> None:
    told = {name: peers.about(name) for name in PEERS}
    told["vmas"]["missing"] = "not installed"
    result: dict[str, Any] = {"machine": _machine(), "results": {}, "noise": {}, "peers": told, "rounds": {}}
    player = Player("irsim", None, rounds=[(1.0, 0.25)], failure="it died")  # type: ignore[arg-type]
    peers._note("s1_single", [player], result)
    Draft202012Validator(json.loads(results.SCHEMA.read_text(encoding="utf-8"))).validate(result)
    assert result["peers"]["irsim"]["failures"] == {"s1_single irsim": "it died"}
    assert result["rounds"] == {
        "s1_single": {"irsim": {"played": 1, "rejected": 0, "disturbed": 0, "calibration_us": 2.5e5}}
    }


def _machine() -> dict[str, Any]:
    text = dict.fromkeys(("processor", "system", "python", "commit", "date"), "x")
    return {**text, "cores": 2, "load": 0.5, "versions": {"numpy": "2.0"}}


@pytest.mark.parametrize(("name", "corners"), [("s1", True), ("cave", False)])
def test_ir_sim_in_its_wrapper_sees_what_we_see_and_is_paid_the_same(name: str, corners: bool) -> None:
    scenario = standard_worlds.s1() if name == "s1" else standard_worlds.s3(name)
    starts = peers.starts_of(scenario)[:5]
    worlds = Worlds(scenario, 5)
    worlds.begin(range(5), range(5), [{}] * 5, lambda w: w)
    ours = [worlds.observation()[1:].copy()]
    with silent():
        wrapper = irsim_peer.Wrapper({"scenario": scenario, "starts": starts})
        # It starts at the first place when it is made, and here at the others.
        played = [(wrapper.reset(), *wrapper.step()) for _ in range(4)]
    actions = worker.random_actions(4, 2)
    worlds.step(np.array([actions[0], *actions], np.float32)[:, None])
    ours.append(worlds.observation()[1:])
    before, after, rewards, *_ = zip(*played, strict=True)
    np.testing.assert_allclose(rewards, worlds.episodes.view.reward[1:, 0], rtol=0.0, atol=1e-7)
    for theirs, mine in zip((before, after), ours, strict=True):
        apart = np.abs(np.array(theirs) - mine)
        assert apart[:, 180:].max() < 1e-6
        # Its circles are polygons of 64 corners, and a beam that grazes one may miss it.
        assert np.quantile(apart[:, :180], 0.97) < (2e-3 if corners else 1e-5)
