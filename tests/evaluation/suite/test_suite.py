"""The suite: what it consists of, playing it in parts, its figures and its tables."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from command_line import run
from robustness_rows import made, result

from irsim_gym.errors import IrsimGymError, ScenarioError, UnknownNameError
from irsim_gym.evaluation import Robustness, robustness
from irsim_gym.evaluation.levels.certificate import read_certificate
from irsim_gym.evaluation.levels.draw import draw_levels
from irsim_gym.evaluation.measures.metrics import EpisodeRow
from irsim_gym.evaluation.measures.team_metrics import AgentRow, TeamRow
from irsim_gym.evaluation.protocol.tables import plain
from irsim_gym.evaluation.requests.episode_setup import make_episodes, team_conditions
from irsim_gym.evaluation.requests.methods import ComparedMethod, read_methods
from irsim_gym.evaluation.suite import playing, suite_tables
from irsim_gym.evaluation.suite.members import Member, read_suite, shipped_suite
from irsim_gym.evaluation.suite.playing import play_suite
from irsim_gym.evaluation.suite.row_files import read_rows, write_rows
from irsim_gym.evaluation.suite.scores import overall, score_member
from irsim_gym.evaluation.suite.suite_record import read_record
from irsim_gym.scenario.specs.level_set import set_hash
from irsim_gym.scenario.specs.library import configs_folder

GOAL = Member("goal", "To drive to a goal.", "empty_goal")
FIXED = Member("fixed", "To drive.", "jaxnav_single_nav_1", levels=1)
SWAP = Member("swap", "To change sides.", "circle_swap", {"n_robots": 2}, team=True)
DASH, RANDOM = ComparedMethod("dash", ("dash",)), ComparedMethod("random", ("random",))


def level(number: int, *outcomes: str, time: float = 5.0) -> TeamRow:
    episodes = [
        EpisodeRow(number, outcome, "map" if outcome == "collision" else "", 50, time, 6.0, 4.5, 0.25, 4.0, 0.5, 2.0)
        for outcome in outcomes
    ]
    agents = [AgentRow(f"robot_{a}", episode, 4.0, 1.0, False) for a, episode in enumerate(episodes)]
    return TeamRow(number, 30.0, tuple(agents))


def test_the_tiers_of_the_shipped_suite_are_its_members() -> None:
    suite = shipped_suite()
    assert all(len(set(names)) == len(names) for names in suite.tiers.values())
    assert set(suite.tiers["core"]) <= set(suite.tiers["full"])
    assert [member.name for member in suite.chosen(["core"])] == [n for n in suite.members if n in suite.tiers["core"]]
    with pytest.raises(UnknownNameError, match=r"no tier or benchmark of the suite named 'cor' \(did you mean 'core'"):
        suite.chosen(["cor"])


def test_the_robot_tier_disturbs_what_has_a_lidar_in_core() -> None:
    suite = shipped_suite()
    core = {one.name: one for one in suite.chosen(["core"])}
    seeing = [name for name, one in core.items() if conditions_of(one)["beams"]]
    robot = suite.chosen(["robot"])
    assert [one.name for one in robot] == [f"{name}_disturbed" for name in core if name in seeing]
    for one, name in zip(robot, seeing, strict=True):
        plain = core[name]
        assert (one.scenario, one.parameters, one.team, one.disturbed) == (name, plain.parameters, plain.team, "all")


def conditions_of(member: Member) -> dict[str, Any]:
    return team_conditions(make_episodes(member.scenario, parameters=member.parameters, team=member.team), "test", 1)


def test_a_disturbed_benchmark_is_the_end_of_a_curve_on_the_same_levels(tmp_path: Path) -> None:
    members, method = shipped_suite().chosen(["cluttered_room", "cluttered_room_disturbed"]), "cluttered_room"
    record = play_suite(members, [ComparedMethod(method, (method,))], tmp_path, levels=12)
    plain, disturbed = (record.members[one.name]["conditions"] for one in members)
    assert {key for key in plain if plain[key] != disturbed[key]} == {"noise"}
    assert (plain["certificate"], disturbed["noise"]) == ("cluttered_room", 0.03)
    curve = robustness("cluttered_room", method, factors=["all"], levels=12).curve("all", method)
    figures = [record.figures[one.name][method] for one in members]
    assert [one["success"]["value"] for one in figures] == [curve[0].success.value, curve[-1].success.value]
    assert figures[0]["time"] < figures[1]["time"]
    shown = suite_tables.member_markdown(record, members[1].name)
    assert "6 m noise of 0.03 m; disturbed by `latency:time=0.2 * 1; drive_lag:tau=0.2 * 1; " in shown
    assert "disturbed" not in suite_tables.member_markdown(record, members[0].name)


def test_the_latency_that_costs_five_points_is_a_column(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 99 % 94 % are left, of 99 and 84 % after a third of a step of 0.2 s. Of three seeds the middle one counts.

    As texts, 11.87 and > 0.2 would be less than 2.07.
    """
    asked: list[dict[str, Any]] = []
    late = {"dash": (99, 97, 95), "ppo-1": (99, 99), "ppo-2": (*[99] * 11, 84), "ppo-3": (*[99] * 60, 84)}
    late |= {"lost": (3, 0)}

    def curves(scenario: str, policies: dict[str, Sequence[str]], **how: Any) -> Robustness:
        asked.append({"scenario": scenario, "policies": policies, **how})
        return result(*(row for name, successes in late.items() for row in made(name, *successes)))

    monkeypatch.setattr(playing, "robustness", curves)
    methods = [DASH, ComparedMethod("ppo", ("random", "dash", "rvo")), ComparedMethod("lost", ("dash",))]
    member = replace(GOAL, name="goal", disturbed="drive_lag")
    play_suite([member], methods, tmp_path, levels=2, latency=True)
    record = read_record(tmp_path)
    each = [one["latency_at_loss"]["value"] for one in record.runs["goal"]["ppo"]]
    assert each == [None, pytest.approx(2.0 + 0.2 / 3), pytest.approx(11.8 + 0.2 / 3)]
    assert record.figures["goal"]["ppo"]["latency_at_loss"]["value"] == each[2]
    assert asked == [
        {
            "scenario": "empty_goal",
            "policies": {"dash": ("dash",), "ppo": ("random", "dash", "rvo"), "lost": ("dash",)},
            **{"factors": ["latency"], "split": "test", "folder": tmp_path / "latency" / "goal"},
            **{"parameters": {}, "team": False, "levels": 2},
        }
    ]
    head, _, *rows = suite_tables.member_markdown(record, "goal").splitlines()[-5:]
    place = head.split(" | ").index("latency at -5 [s]")
    assert [row.split(" | ")[place] for row in rows] == ["> 0.4", "11.87", "-"]
    again = play_suite([member], methods, tmp_path, levels=2)
    assert plain(again.figures) == record.figures
    anew = play_suite([member], methods, tmp_path, levels=2, overwrite=True)
    assert anew.figures["goal"]["dash"]["latency_at_loss"] is None


def test_all_mistakes_of_a_suite_are_named_at_once(tmp_path: Path) -> None:
    file = tmp_path / "suite.yaml"
    file.write_text(
        "benchmarks:\n  a: {asks: x, scenario: corridr, tem: true}\n  cave: {}\ntiers: {core: [cav], cave: [cave]}\n"
    )
    known = "asks, scenario, parameters, disturbed, team, levels, differs"
    assert mistakes_of(file) == [
        ":2   benchmarks.a.scenario: no shipped scenario 'corridr' (did you mean 'corridor'?)",
        f":2   benchmarks.a.tem: unknown key (did you mean 'team'?); known: {known}",
        ":3   benchmarks.cave.asks: is missing; say what it asks of a policy",
        ":4   tiers.cave: is also the name of a benchmark",
        ":4   tiers.core[0]: no benchmark 'cav' (did you mean 'cave'?)",
    ]


def mistakes_of(file: Path) -> list[str]:
    with pytest.raises(ScenarioError) as told:
        read_suite(file)
    return sorted(line.removeprefix(f"  {file}") for line in str(told.value).splitlines()[1:])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("benchmarks: [maze]\ntiers: {core: [maze]}\n", "benchmarks: must be a mapping, got ['maze']"),
        ("benchmarks: {maze: 3}\ntiers: {core: [maze]}\n", "benchmarks.maze: must be a mapping, got 3"),
        ("benchmarks: {maze: {levels: many}}\ntiers: {}\n", "levels: must be a whole number > 0, got 'many'"),
        ("benchmarks: {maze: {asks: x}}\ntiers: {core: 5}\n", "tiers.core: must be a list of benchmarks, got 5"),
        ("benchmarks: {maze: {asks: x}}\ntiers: {core: [[maze]]}\n", "tiers.core[0]: no benchmark"),
        ("- 1\n", "benchmarks: must be a mapping, got nothing"),
        ("", "the file is empty"),
        ("benchmarks: {maze: {disturbed: [all]}}\ntiers: {}\n", "disturbed: must be a factor of `irsim-gym rob"),
        ("benchmarks: {maze: {disturbed: al}}\ntiers: {}\n", "got 'al'"),
        ("benchmarks: {maze: {parameters: [1]}}\ntiers: {}\n", "parameters: must be a mapping of values by name"),
    ],
)
def test_a_suite_of_another_form_is_told_with_its_line(text: str, told: str, tmp_path: Path) -> None:
    file = tmp_path / "suite.yaml"
    file.write_text(text)
    assert any(told in line for line in mistakes_of(file)), mistakes_of(file)


def test_methods_are_policies_or_named_seeds() -> None:
    methods = read_methods(["dash", "ppo=runs/a,runs/b", "x/policy.zip"])
    assert methods == [DASH, ComparedMethod("ppo", ("runs/a", "runs/b")), ComparedMethod("x", ("x/policy.zip",))]
    assert read_methods(["seen=pursuit:known=seen", "rvo:vxmax=1"])[0] == ComparedMethod(
        "seen", ("pursuit:known=seen",)
    )
    with pytest.raises(IrsimGymError, match="two methods are named 'dash'"):
        read_methods(["dash", "dash=orca"])
    with pytest.raises(IrsimGymError, match="needs policies, divided by commas, got 'a,'"):
        read_methods(["ppo=a,"])


def test_a_run_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "run"
    record = play_suite([GOAL, SWAP], [DASH], folder, levels=3)
    assert [len(read_rows(folder / f"rows/{name}/dash-0.csv")) for name in ("goal", "swap")] == [3, 3]
    assert record.figures["goal"]["dash"]["success"]["value"] == 1.0
    played: list[int] = []
    evaluate = playing.evaluate_team
    monkeypatch.setattr(playing, "evaluate_team", lambda *a, **k: played.append(1) or evaluate(*a, **k))  # type: ignore[func-returns-value]
    again = play_suite([GOAL, SWAP], [DASH], folder, levels=3)
    assert (played, again.figures) == ([], record.figures)
    more = play_suite([GOAL], [DASH, RANDOM], folder, levels=3)
    assert (played, list(more.figures["goal"]), list(more.figures["swap"])) == ([1], ["dash", "random"], ["dash"])
    assert read_record(folder) == more
    drawn = draw_levels(make_episodes("empty_goal").simulation, ["test"], 3)
    assert more.members["goal"]["conditions"]["level_hash"] == set_hash(drawn.hashes())
    with pytest.raises(IrsimGymError, match="holds 3 test levels of each benchmark, asked for: 4 test levels"):
        play_suite([GOAL], [DASH], folder, levels=4)
    with pytest.raises(IrsimGymError, match="the scenario of swap changed since rows were played"):
        play_suite([replace(SWAP, parameters={"n_robots": 3})], [DASH], folder, levels=3)
    with pytest.raises(IrsimGymError, match="the policies of dash changed"):
        play_suite([GOAL], [replace(DASH, sources=("rvo",))], folder, levels=3)
    assert list(play_suite([GOAL], [RANDOM], folder, levels=1, overwrite=True).figures) == ["goal"]


def test_a_policy_that_does_not_fit_is_left_out_and_named(tmp_path: Path) -> None:
    record = play_suite(
        [Member("car", "To park.", "car_dash")], [ComparedMethod("rvo", ("rvo",)), DASH], tmp_path, levels=1
    )
    assert list(record.figures["car"]) == ["dash"]
    assert "Without rvo: 'rvo' cannot drive kinematics 'acker'" in suite_tables.markdown(record)


def test_a_benchmark_that_nobody_can_drive_has_a_reason_in_the_place_of_a_table(tmp_path: Path) -> None:
    crowd, dwa = Member("crowd", "To cross.", "crowd_nav"), ComparedMethod("dwa", ("dwa",))
    record = play_suite([GOAL, crowd], [dwa], tmp_path, levels=1)
    assert (list(record.figures["goal"]), list(record.figures["crowd"])) == ([], [])
    shown = suite_tables.markdown(record)
    assert re.search(r"Without dwa: 'dwa' reads a scan, but 'robot_0' \(benchmarks.crowd_nav\.yaml:\d+\) has no", shown)
    assert "|" not in shown


def test_rows_survive_their_file(tmp_path: Path) -> None:
    levels = [level(0, "success", "collision"), level(3, "timeout", "success", time=math.pi)]
    lone = replace(levels[1].agents[0].episode, level=5, optimum=math.inf)
    levels.append(TeamRow(5, 30.0, (replace(levels[1].agents[0], episode=lone),)))
    write_rows(tmp_path / "rows.csv", levels)
    found = read_rows(tmp_path / "rows.csv")
    assert [row.level for row in found] == [0, 3, 5]
    assert found[0] == levels[0]
    assert found[1].agents[1].episode.time == pytest.approx(math.pi, abs=1e-6)
    assert found[2].agents[0].episode.optimum == math.inf
    text = (tmp_path / "rows.csv").read_text()
    (tmp_path / "rows.csv").write_text(text.replace(",jerk,", ",jolt,"))  # a file of an earlier version
    assert math.isnan(read_rows(tmp_path / "rows.csv")[0].agents[0].episode.jerk)
    (tmp_path / "rows.csv").write_text(text.replace("success", "success,9", 1).replace(",50,", ",many,"))
    with pytest.raises(IrsimGymError, match=r"rows.csv:2 is no row of an episode: a row must have 25 cells"):
        read_rows(tmp_path / "rows.csv")
    (tmp_path / "rows.csv").write_text("level,outcome\n")
    with pytest.raises(IrsimGymError, match=r"rows.csv:1 is no table of episodes: no column hit, steps"):
        read_rows(tmp_path / "rows.csv")


def solo(*outcomes: str, time: float = 5.0) -> Sequence[TeamRow]:
    return [level(number, outcome, time=time) for number, outcome in enumerate(outcomes)]


def test_figures_worked_by_hand() -> None:
    ours = [solo("success", "success", "collision", "timeout"), solo("success", "success", "success", "timeout")]
    others = [solo("success", "collision", "success", "success", time=8.0)]
    scores = score_member({"ours": ours, "others": others})
    mine, other = (SimpleNamespace(**scores[name]) for name in ("ours", "others"))
    assert (mine.repetitions, mine.success.value, mine.individual) == (2, pytest.approx(5 / 8), pytest.approx(5 / 8))
    assert mine.outcomes["collision"] == mine.hits["map"] == pytest.approx(1 / 8)
    assert mine.spl == pytest.approx(5 / 8 * 4.5 / 6.0)
    assert mine.sct == pytest.approx(5 / 8 * 4.0 / 5.0)
    # The worst level by the first policy is the third, which the second solves; by the second the fourth, unsolved.
    assert (mine.worst_shared["5 %"], other.worst_shared) == (pytest.approx(0.5), {})
    assert (mine.worst["5 %"], other.worst["5 %"]) == (0.0, 0.0)
    # Both policies of ours solved levels 0 and 1, the others 0, 2 and 3.
    assert (mine.common_levels, mine.common_time, other.common_time) == (1, 5.0, 8.0)
    apart = SimpleNamespace(
        **score_member({"ours": [solo("success", "timeout")], "others": [solo("timeout", "success")]})["ours"]
    )
    assert (apart.common_levels, math.isnan(apart.common_time), math.isnan(apart.common_path)) == (0, True, True)
    assert (mine.acceleration, mine.jerk, mine.clearance) == (0.5, 2.0, 0.25)
    team = score_member({"team": [[level(0, "success", "success"), level(1, "success", "collision")]]})["team"]
    assert (team["success"].value, team["individual"], team["makespan"]) == (0.5, 0.75, pytest.approx((5.0 + 30.0) / 2))


def test_figures_of_people_and_of_difficulty_worked_by_hand() -> None:
    near = {"intrusion_025": 0.1, "intrusion_045": 0.3, "time_to_collision": 2.0}
    met = [replace(row.agents[0].episode, **near) for row in solo("success", "collision", "success", "timeout")]
    met[3] = replace(met[3], intrusion_025=0.5, time_to_collision=math.inf)  # it met nobody
    rows = [TeamRow(one.level, 30.0, (AgentRow("robot_0", one, 4.0, 1.0, False),)) for one in met]
    quarters = np.array([1, 0, 2, 3])
    score = SimpleNamespace(**score_member({"ours": [rows]}, quarters)["ours"])
    assert list(score.quarters.values()) == [0.0, 1.0, 1.0, 0.0]
    assert (score.intrusion_025, score.intrusion_045) == (pytest.approx(0.2), pytest.approx(0.3))
    assert score.time_to_collision == 2.0
    without = score_member({"ours": [solo("success", "success")]})["ours"]
    assert without["quarters"] == {}
    assert math.isnan(without["intrusion_025"])


def test_overall_figures_are_of_benchmarks_that_all_played() -> None:
    success = {"a": {"x": [0.9, 0.8], "y": [0.5]}, "b": {"x": [0.2, 0.4], "y": [0.3]}, "c": {"x": [1.0]}}
    found = overall(success, ["x", "y"])
    assert found["benchmarks"] == ["a", "b"]
    assert found["success"]["x"].value == pytest.approx((0.4 + 0.8) / 2)  # the middle half of four
    assert found["improvement"]["x"]["y"].value == pytest.approx((1.0 + 0.5) / 2)


def test_the_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def suite(*arguments: object) -> tuple[int, str]:
        status = run(monkeypatch, "suite", *arguments)
        said = capsys.readouterr()
        return status, said.out + said.err

    assert "irsim_gym/bug_trap-v0" in suite("list", "core", "bug_trap")[1]
    assert "irsim_gym/maze-v0, disturbed by the factor all of robustness" in suite("list", "robot")[1]
    late = suite("run", "cluttered_room", "cluttered_room", "--levels", 2, "--latency", "--out", tmp_path / "late")[1]
    assert " latency at -5 [s] |" in late
    folder = tmp_path / "run"
    assert "| dash |" in suite("run", "bug_trap", "dash", "--levels", 2, "--out", folder)[1]
    assert "| dash |" in suite("table", folder)[1]
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "file").touch()
    status, said = suite("run", "bug_trap", "dash", "--out", tmp_path / "other")
    assert (status, "is not empty, and holds no run of the suite" in said) == (1, True)


def test_tables_show_the_columns_that_rows_have(tmp_path: Path) -> None:
    room = Member("room", "To find a way.", "cluttered_room")
    record = play_suite([room, SWAP], [DASH, RANDOM], tmp_path, levels=4)
    certificate = read_certificate(configs_folder() / "certificates" / "cluttered_room.npz")
    of = record.members["room"]["conditions"]
    assert (of["certificate"], of["certified_by"]) == (certificate.name, list(certificate.policies))
    assert of["unsolved"] == int((~certificate.solved[:4]).sum())
    quarters = record.figures["room"]["dash"]["quarters"]
    assert sum(quarters.values()) / 4 == record.figures["room"]["dash"]["success"]["value"]
    single, team = (suite_tables.member_markdown(record, name) for name in ("room", "swap"))
    assert f"fail, the policies of the certificate. Levels that none of them solves: {of['unsolved']} of 4." in single
    assert ("easiest quarter" in single, "easiest quarter" in team) == (True, False)
    assert ("makespan" in single, "makespan" in team) == (False, True)
    assert "| needs |" not in single
    record.runs["room"]["dash"][0]["observes"] = ["scan", "goal", "position"]
    assert "| scan, odometry, map_frame |" in suite_tables.member_markdown(record, "room")
    assert "within 0.25 m" not in single
    assert "worst 5 % [%]" in single
    assert "shared" not in single  # no method has several policies
    crowd = replace(level(0, "success"), agents=(met_somebody(),))
    record.figures["room"] = plain(score_member({"dash": [[crowd]]}))
    assert "| steps within 0.25 m [%] | within 0.45 m [%] | time to collision [s] |" in suite_tables.markdown(record)


def met_somebody() -> AgentRow:
    row = level(0, "success").agents[0]
    return replace(row, episode=replace(row.episode, intrusion_025=0.1, intrusion_045=0.2, time_to_collision=3.0))


def test_tables_name_their_conditions(tmp_path: Path) -> None:
    record = play_suite([SWAP, GOAL, FIXED], [DASH, RANDOM], tmp_path, levels=2)
    said = suite_tables.markdown(read_record(tmp_path))
    assert said == suite_tables.markdown(record)
    for words in (
        "n_robots = 2; 2 test levels; 2 learners; footprint circle 0.2 m; goal tolerance 0.3 m; ",
        "velocities 0 to 1 and -1.5 to 1.5 m/s, rad/s; accelerations unlimited; step 0.1 s; ",
        "time limit 300 steps (30 s); 180 beams up to 6 m without noise; scenario ",
        "1 test level; 1 learner; footprint rectangle 0.5 x 0.5 m; goal tolerance 0.3 m; velocities 0 to 1 and -0.6 ",
        "accelerations 1, 1; step 0.1 s; time limit 500 steps (50 s); 200 beams up to 6 m without noise; ",
    ):
        assert words in said
    assert "over: swap, goal, fixed." in said
    assert "| fixed | 0.0 (0.0-79.3) | 0.0 (0.0-79.3) |" in said  # Wilson's interval for 0 of 1
    assert suite_tables.overview(record) in said
    assert json.loads((tmp_path / "summary.json").read_text())["machine"]["versions"]["irsim_gym"]
    with pytest.raises(IrsimGymError, match="holds no run of the suite"):
        read_record(tmp_path / "none")
