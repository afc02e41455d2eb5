"""Success over the strength of disturbances: `irsim-gym robustness`."""

from __future__ import annotations

import csv
import json
import math
import shutil
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from command_line import run
from robustness_rows import ROOM, made, result
from test_readme import DOCS, blocks, commands

import irsim_gym
from irsim_gym.base.families import DISTURBANCES
from irsim_gym.base.options import drawn_ends
from irsim_gym.errors import IrsimGymError, UnknownNameError
from irsim_gym.evaluation import robustness
from irsim_gym.evaluation.curves import robustness as module
from irsim_gym.evaluation.curves.factors import Factor, chosen_factors, disturbed, every_factor
from irsim_gym.evaluation.saved_policies.shelf import shelf_files
from irsim_gym.rendering.figures.strengths_plot import draw_strengths
from irsim_gym.scenario.reading.perturbations import read_perturbations

BLIND = {
    "world": {"height": 8, "width": 8, "name": "bare"},
    "robot": {"kinematics": {"name": "diff"}, "state": [1, 1, 0.8], "goal": [5, 5]},
    "task": {"name": "navigation"},
}


@pytest.fixture
def plays(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is played from now on."""
    played: list[str] = []
    play = module.play

    def counted(policies: dict[str, object], *args: object, **how: object) -> object:
        played.extend(policies)
        return play(policies, *args, **how)  # type: ignore[arg-type]

    monkeypatch.setattr(module, "play", counted)
    return played


def test_every_kind_of_disturbance_has_a_factor() -> None:
    kinds = {text.partition(":")[0] for factor in every_factor() for text in factor.perturb}
    assert kinds == set(DISTURBANCES.names())


@pytest.mark.parametrize("factor", every_factor(), ids=lambda factor: factor.name)
def test_strengths_grow(factor: Factor) -> None:
    """Each can be read, and something of it grows from one strength to the next."""
    assert list(factor.strengths) == sorted(set(factor.strengths))
    assert factor.strengths[0] > 0.0
    for weak, strong in pairwise([sizes(factor, strength) for strength in factor.strengths]):
        assert all(a <= b for a, b in zip(weak, strong, strict=True))
        assert sum(weak) < sum(strong)


def sizes(factor: Factor, strength: float) -> list[float]:
    """Return all numbers that a strength may change, without their signs."""
    every = read_perturbations(factor.text(strength))
    ends = [end for one in every for both in drawn_ends(one).values() for end in both]
    fixes = [one.fix.std for one in every if getattr(one, "fix", None) is not None]
    return [*map(abs, ends), *fixes, factor.noise * strength]


def test_factors_are_chosen_by_their_name_or_kind() -> None:
    names = [factor.name for factor in chosen_factors(["range_bias", "latency"])]
    assert names == ["latency", "range_long", "range_short"]
    assert [factor.name for factor in chosen_factors(["range_short"])] == ["range_short"]
    assert chosen_factors(None) == every_factor()
    with pytest.raises(
        UnknownNameError, match=r"no factor named 'latncy' \(did you mean 'latency'\?\); factors: latency, drive_lag, "
    ):
        chosen_factors(["latncy"])


def test_the_text_of_a_strength() -> None:
    by_name = {factor.name: factor for factor in every_factor()}
    assert by_name["latency"].text(0.3) == "latency:time=0.3"
    (sector,) = read_perturbations(by_name["blind_sector"].text(90))
    assert sector.width == pytest.approx(math.pi / 2)
    (short,) = read_perturbations(by_name["range_short"].text(5))
    assert short.offset == pytest.approx(-0.05)
    everything = read_perturbations(by_name["all"].text(1))
    assert {"Latency", "DriveLag", "RangeBias", "LostBeams"} <= {type(one).__name__ for one in everything}
    assert next(one.offset for one in everything if type(one).__name__ == "RangeBias") == (-0.03, 0.03)
    assert by_name["all"].noise == 0.03


def test_five_points_are_lost_between_two_strengths() -> None:
    """99 % less 5 is 94 %, a fifth of the way from 97 % at 0.2 s to 82 % at 0.4 s."""
    assert result(*made("p", 99, 97, 82, 95)).lost_at("latency", "p") == pytest.approx(0.2 + 0.2 * 3 / 15)
    assert result(*made("p", 99, 94)).lost_at("latency", "p") == pytest.approx(0.2)
    assert result(*made("p", 99, 95, 96)).lost_at("latency", "p") == math.inf
    assert math.isnan(result(*made("p", 4, 0)).lost_at("latency", "p"))
    assert math.isnan(result(*made("p", 99)).lost_at("latency", "p"))


def test_tables_say_where_and_what_they_mean() -> None:
    """Wilson's interval of 8 of 10 is 49.0 to 94.3 %."""
    found = result(*made("fine", 99, 97, 82), *made("firm", 99, 99), *made("poor", 8, 8, of=10), *made("none", 0, 0))
    found.left_out["lost_beams"] = "the robot has no range sensor"
    text = str(found)
    assert "| latency [s] | 0.24 | > 0.2 | > 0.2 | - |" in text
    assert "| undisturbed | 99.0 (94.6-99.8); 0.0 | 99.0 (94.6-99.8); 0.0 | 80.0 (49.0-94.3); 0.0 |" in text
    assert "| latency 0.4 s | 82.0 (73.3-88.3); 0.0 | - | - | - |" in text
    assert "Undisturbed success of none is only 0.0 %." in text
    assert "of poor" not in text
    assert "Without lost_beams: the robot has no range sensor." in text


def test_rows_are_those_of_an_evaluation(tmp_path: Path) -> None:
    found = robustness(ROOM, [ROOM, "dash"], factors=["latency"], levels=24, folder=tmp_path)
    assert [row.label for row in found.curve("latency", "dash")][:2] == ["undisturbed", "latency 0.1 s"]
    for disturbances, strength in (("", 0.0), ("latency:time=0.5", 0.5)):
        own = irsim_gym.evaluate(
            ROOM, [ROOM, "dash"], levels=24, references=False, parameters={"disturbances": disturbances}
        )
        for one in own.summaries:
            (row,) = (row for row in found.curve("latency", one.policy) if row.strength == strength)
            assert (row.success, row.collision, row.disturbances) == (one.success, one.collision, disturbances)
    assert found.curve("latency", ROOM)[-1].success.value < found.curve("latency", ROOM)[0].success.value
    with (tmp_path / "robustness.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["success"]) for row in rows] == pytest.approx([row.success.value for row in found.rows], abs=1e-6)
    data = json.loads((tmp_path / "robustness.json").read_text())
    assert data["lost_5_points_at"][ROOM]["latency"] == found.lost_at("latency", ROOM)
    assert (tmp_path / "robustness.md").read_text() == str(found)
    assert (tmp_path / "robustness.png").read_bytes().startswith(b"\x89PNG")


def test_what_is_on_disk_is_not_played_again(tmp_path: Path, plays: list[str]) -> None:
    how = {"levels": 4, "folder": tmp_path}
    first = robustness("empty_goal", "dash", factors=["drive_lag"], **how)
    assert len(plays) == 6
    plays.clear()
    assert robustness("empty_goal", "dash", factors=["drive_lag"], **how).rows == first.rows
    assert plays == []
    more = robustness("empty_goal", ["dash", "random"], factors=["latency", "drive_lag"], **how)
    late = [f"latency {strength}, dash" for strength in ("0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.8")]
    assert [name for name in plays if name.endswith("dash")] == late
    assert len([name for name in plays if name.endswith("random")]) == 13
    plays.clear()
    record = tmp_path / "robustness.json"
    data = json.loads(record.read_text())
    data["rows"].pop()
    record.write_text(json.dumps(data))
    assert robustness("empty_goal", ["dash", "random"], factors=["drive_lag"], **how).rows == more.rows
    assert plays == ["drive_lag 0.8, random"]


def test_a_change_is_noticed(tmp_path: Path, plays: list[str]) -> None:
    folder, policy, scenario = tmp_path / "out", tmp_path / "mine.npz", tmp_path / "room.yaml"
    shutil.copy(shelf_files()[ROOM], policy)
    scenario.write_text(irsim_gym.scenario.find(ROOM).read_text())
    robustness(scenario, policy, factors=["latency"], levels=2, folder=folder)
    plays.clear()
    for change, why in (
        (lambda: shutil.copy(shelf_files()["dense_room"], policy), "policy mine [0-9a-f]{64}, now"),
        (lambda: scenario.write_text(scenario.read_text().replace("range_max: 6", "range_max: 5")), "sha256"),
    ):
        change()
        with pytest.raises(IrsimGymError, match=f"out holds rows of before a change: .*{why}"):
            robustness(scenario, policy, factors=["latency"], levels=2, folder=folder)
    with pytest.raises(IrsimGymError, match=r"levels 2, now 3.*--overwrite"):
        robustness(scenario, policy, factors=["latency"], levels=3, folder=folder)
    assert plays == []
    assert len(robustness(scenario, policy, factors=["latency"], levels=3, folder=folder, overwrite=True).rows) == 8
    (folder / "robustness.json").write_text('{"rows": 3}')
    with pytest.raises(IrsimGymError, match=r"robustness\.json.*record of robustness"):
        robustness(scenario, policy, factors=["latency"], levels=3, folder=folder)


def test_a_factor_with_other_disturbances_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As after a new release, or where another module registers a kind."""
    how = {"factors": ["latency"], "levels": 2, "folder": tmp_path}
    robustness("empty_goal", "dash", **how)
    other = replace(chosen_factors(["latency"])[0], perturb=("latency:time={}", "drive_lag:tau={}"))
    monkeypatch.setattr(module, "chosen_factors", lambda names: [other])
    with pytest.raises(
        IrsimGymError, match=r"factor latency latency:time=\{\}, noise 0, now latency:time=\{\}; drive_lag"
    ):
        robustness("empty_goal", "dash", **how)


def test_functions_are_never_taken_for_those_of_before(tmp_path: Path) -> None:
    """Nothing on disk tells two functions apart."""
    how = {"factors": ["latency"], "levels": 2, "folder": tmp_path}
    drive = lambda seen: [[0.0, 0.0]] * len(seen)  # noqa: E731
    robustness("empty_goal", {"mine": drive}, **how)
    with pytest.raises(IrsimGymError, match="policy mine"):
        robustness("empty_goal", {"mine": drive}, **how)


def test_noise_is_added_to_that_of_the_sensor() -> None:
    """Deviations of 3 and 4 cm make one of 5 cm."""
    base = irsim_gym.load_scenario(ROOM)
    (plain,) = disturbed(base, (0,), "", 0.04).bodies[0].sensors
    assert (plain.noise, plain.std, plain.angle_std) == (True, 0.04, 0.0)
    noisy = replace(base.bodies[0].sensors[0], noise=True, std=0.03, angle_std=0.01)
    own = replace(base, bodies=(replace(base.bodies[0], sensors=(noisy,)), *base.bodies[1:]))
    (both,) = disturbed(own, (0,), "", 0.04).bodies[0].sensors
    assert (both.noise, both.std, both.angle_std) == (True, pytest.approx(0.05), 0.01)


def test_factors_that_do_not_fit_are_left_out() -> None:
    found = robustness(BLIND, "dash", factors=["latency", "lost_beams", "range_noise"], levels=2)
    assert set(found.factors) == {"latency"}
    assert set(found.left_out) == {"lost_beams", "zero_beams", "range_noise"}
    assert "no range sensor" in found.left_out["lost_beams"]
    assert "has no sensor with noise" in found.left_out["range_noise"]
    assert "Without zero_beams: " in str(found)


def test_teams_are_disturbed_as_a_whole() -> None:
    found = robustness("random_swap", "orca", team=True, factors=["drive_lag"], levels=3)
    own = irsim_gym.evaluate(
        "random_swap", "orca", team=True, levels=3, references=False, parameters={"disturbances": "drive_lag:tau=0.8"}
    )
    row = found.curve("drive_lag", "orca")[-1]
    assert (row.strength, row.success) == (0.8, own.summaries[0].cooperative_success)


def test_the_figure_has_a_panel_for_each_factor(tmp_path: Path) -> None:
    points = [(0.0, 99.0, 97.0, 100.0), (0.2, 60.0, 50.0, 70.0)]
    panels = {
        "latency [s]": {"a$": (points, 0.03), "b": (points[:1], math.nan)},
        "slip [%]": {"a$": (points, math.inf), "b": (points, 0.1)},
    }
    draw_strengths([tmp_path / "one.svg"], panels, "corridor, 5 levels")
    drawn = (tmp_path / "one.svg").read_text()
    for words in ("latency [s]", "slip [%]", "a$", "success [%]", "corridor, 5 levels", "Bands: 95 % intervals."):
        assert drawn.count(f">{words}") == 1
    assert drawn.count("stroke-dasharray") == 2


def test_the_command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    command = ("robustness", "empty_goal", "dash", "--factors", "drive_lag", "--levels", 3)
    assert run(monkeypatch, *command) == 0
    said = capsys.readouterr()
    assert "| drive_lag 0.8 s | 100.0 (43.9-100.0); 0.0 |" in said.out
    assert "drive_lag 0.8 s, dash: 100.0 %" in said.err
    assert (tmp_path / "runs" / "robustness-empty_goal-test" / "robustness.csv").is_file()
    assert run(monkeypatch, *command) == 0
    assert capsys.readouterr().err == ""
    assert run(monkeypatch, *command, "--factors", "lag") == 1
    assert "no factor named 'lag'" in capsys.readouterr().err


def test_the_page_shows_what_works(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    page = DOCS / "disturbances.md"
    monkeypatch.chdir(tmp_path)
    (command,) = (line for line in commands(page) if line.startswith("irsim-gym robustness "))
    assert run(monkeypatch, *command.split()[1:]) == 0
    (block,) = (block for block in blocks(page, "python") if "robustness(" in block.text)
    exec(compile(block.text, str(block), "exec", dont_inherit=True), {})
