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
import pytest
import results
import standard_worlds
from jsonschema import Draft202012Validator
from peers import REQUIREMENTS, WORKS, Player, figures_of

from irsim_gym.envs.worlds import Worlds

PEERS = sorted(REQUIREMENTS)
OTHERS = [name for name in PEERS if name != "ours"]


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Hold back ir-sim's warnings and what it prints."""
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        yield


class Scripted:
    """A process whose rounds are known beforehand: microseconds and seconds of the calibration loop."""

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
    assert player.failure == "" or "disturbed" in player.failure
    assert player.version


def test_a_process_that_dies_is_reported(tmp_path: Path) -> None:
    asked = argparse.Namespace(round_s=0.0, rounds=1, tiny=True)
    (player,) = peers.measure("s2_orca", {"ours": Path(sys.executable)}, {"ours": ["s2_orca@nowhere"]}, asked)
    assert "s2_orca@nowhere" in player.failure
    assert player.values == []


def test_rounds_take_turns_until_all_have_enough_good_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    calm, _ = scripted("calm", [(2.0, 1.0)], monkeypatch)
    shaken, script = scripted("shaken", [(9.0, 2.0), (3.0, 1.1)], monkeypatch)
    peers._take_turns([calm, shaken], rounds=2)
    assert (calm.values, calm.rejected) == ([2.0, 2.0], 0)
    assert (shaken.values, shaken.rejected, script.asked) == ([3.0, 3.0], 2, 4)


def test_who_is_always_disturbed_is_not_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    calm, _ = scripted("calm", [(2.0, 1.0)], monkeypatch)
    shaken, script = scripted("shaken", [(9.0, 2.0)], monkeypatch)
    peers._take_turns([calm, shaken], rounds=2)
    assert script.asked == 6
    assert "0 of 2" in shaken.failure


def test_how_much_slower_is_a_ratio_of_medians() -> None:
    players = [
        Player("ours", None, values=[1.0, 2.0, 4.0]),  # type: ignore[arg-type]
        Player("irsim", None, values=[100.0, 300.0, 200.0]),  # type: ignore[arg-type]
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


def test_starts_of_a_work_are_free_places() -> None:
    scenario = standard_worlds.s1()
    starts = peers.starts_of(scenario)
    assert len(starts) == peers.N_STARTS
    for x, y, _, goal_x, goal_y in starts:
        assert min(x, y, 10.0 - x, 10.0 - y) >= 0.3
        assert (goal_x - x) ** 2 + (goal_y - y) ** 2 >= 16.0
    assert peers.starts_of(standard_worlds.s2("rvo")) == []


def test_a_result_follows_the_schema() -> None:
    told = {name: peers.about(name) for name in PEERS}
    told["vmas"]["missing"] = "not installed"
    result: dict[str, Any] = {"machine": _machine(), "results": {}, "noise": {}, "peers": told, "rejected_rounds": 3}
    player = Player("irsim", None, values=[1.0], failure="disturbed")  # type: ignore[arg-type]
    peers._note("s1_single", [player], result)
    Draft202012Validator(json.loads(results.SCHEMA.read_text(encoding="utf-8"))).validate(result)
    assert result["peers"]["irsim"]["failures"] == {"s1_single irsim": "disturbed"}


def _machine() -> dict[str, Any]:
    text = dict.fromkeys(("processor", "system", "python", "commit", "date"), "x")
    return {**text, "cores": 2, "load": 0.5, "versions": {"numpy": "2.0"}}


@pytest.mark.parametrize(("name", "corners"), [("s1", True), ("cave", False)])
def test_ir_sim_in_its_wrapper_sees_what_we_see(name: str, corners: bool) -> None:
    scenario = standard_worlds.s1() if name == "s1" else standard_worlds.s3(name)
    starts = peers.starts_of(scenario)[:5]
    worlds = Worlds(scenario, 5)
    worlds.begin(range(5), range(5), [{}] * 5, lambda w: w)
    with silent():
        wrapper = irsim_peer.Wrapper({"scenario": scenario, "starts": starts})
        # It starts at the first place when it is made, and here at the others.
        theirs = np.array([wrapper.reset() for _ in range(4)])
    apart = np.abs(theirs - worlds.observation()[1:])
    assert apart[:, 180:].max() < 1e-6
    # Its circles are polygons of 64 corners, and a beam that grazes one may miss it.
    assert np.quantile(apart[:, :180], 0.97) < (2e-3 if corners else 1e-5)
