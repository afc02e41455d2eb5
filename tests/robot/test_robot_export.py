"""``irsim-gym export``: the files, what they say, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml
from command_line import run

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy
from irsim_gym.evaluation.saved_policies.shelf import read_policy, shelf_file
from irsim_gym.evaluation.saved_policies.shelf_tables import curves_text
from irsim_gym.robot import export
from irsim_gym.robot.contract import RobotContract
from irsim_gym.robot.export import FILES, RobotExport, export_for_robot
from irsim_gym.robot.fitting import Variant, fit
from irsim_gym.robot.graph_policy import DelayedPolicy, GraphPolicy
from irsim_gym.robot.inputs import measured, robot_values
from irsim_gym.robot.policy_graph import policy_graph
from irsim_gym.robot.prediction import pending_spans, predicted
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs.library import find
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import Episodes, load_task
from irsim_gym.tasks.terms.graph import Graph

onnx = pytest.importorskip("onnx")
onnxruntime = pytest.importorskip("onnxruntime")


def test_the_files_of_an_export(exported: RobotExport) -> None:
    assert {file.name for file in exported.folder.iterdir()} == {*FILES} - {"perceive.py", "shield.py"}
    onnx.checker.check_model(onnx.load(exported.folder / "policy.onnx"), full_check=True)
    assert exported.difference <= 1e-5
    assert exported.n_commands > 1000


def test_older_releases_of_onnxruntime_load_the_graph(exported: RobotExport) -> None:
    """Up to 1.21 they need names of nodes, and not all have these operators of float64; tried from 1.17 on."""
    nodes = onnx.load(exported.folder / "policy.onnx").graph.node
    names = {node.name for node in nodes}
    assert len(names) == len(nodes)
    assert "" not in names
    assert not {"Cos", "Gemm", "ReduceL2"} & {node.op_type for node in nodes}


def test_the_check_can_be_repeated_without_the_package(exported: RobotExport) -> None:
    check = np.load(exported.folder / "check.npz")
    session = onnxruntime.InferenceSession(exported.folder / "policy.onnx")
    given = {one.name: check[one.name] for one in session.get_inputs()}
    assert len(check["command"]) == 1000
    assert np.abs(session.run(["command"], given)[0] - check["command"]).max() < 1e-5


def test_the_contract_keeps_to_its_schema(exported: RobotExport) -> None:
    found, schema = (
        json.loads((exported.folder / name).read_text(encoding="utf-8"))
        for name in ("contract.json", "contract.schema.json")
    )
    jsonschema.validate(found, schema)
    assert RobotContract.model_validate(found) == exported.contract
    assert found["needs"] == ["scan", "odometry"]
    assert (found["scan"]["beams"], found["scan"]["range_max"], found["period"]) == (180, 6.0, 0.1)
    assert (found["robot"]["low"], found["robot"]["high"]) == ([0.0, -1.5], [1.0, 1.5])
    ages = {"scan_age": pytest.approx(0.3), "odometry_age": pytest.approx(0.3), "bodies_age": None}
    assert found["stop"] == {**ages, "lost_beams": 0.3}
    assert found["robustness"]["latency"]["5 points lost at"] == pytest.approx(0.2, abs=0.02)
    card = read_policy(shelf_file("cluttered_room")).card
    assert card is not None
    assert exported.contract.robustness == card.robustness
    assert found["states"]["record_nearest"] == {"shape": [1], "dtype": "float64", "start": "inf"}


def test_the_model_card_has_a_front_matter_with_the_success_rate(exported: RobotExport) -> None:
    text = (exported.folder / "README.md").read_text(encoding="utf-8")
    front = yaml.safe_load(text.split("---")[1])
    (metric,) = front["model-index"][0]["results"][0]["metrics"]
    assert metric["type"] == "success_rate"
    assert metric["value"] == "99.3 % [99.1, 99.5] of 10,000 test levels"  # as in the policy's card
    assert max(map(len, text.splitlines())) <= 125


@pytest.mark.parametrize(
    ("policy", "words"),
    [
        ("general", ["'nearest_bodies' needs bodies (the true state of other bodies)"]),
        ("cluttered_room_images", ["'occupancy_image' needs bodies"]),
        ("push_box", ["'movable_bodies' needs bodies", "'contact' needs bodies"]),
        ("dash", ["is no trained policy"]),
    ],
)
def test_what_cannot_leave_is_refused_by_name(policy: str, words: list[str], tmp_path: Path) -> None:
    with pytest.raises(IrsimGymError) as error:
        export_for_robot(policy, tmp_path / "out", levels=1)
    assert all(word in str(error.value) for word in words)
    assert not (tmp_path / "out").exists()


def test_nothing_is_written_where_the_graph_differs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(export, "TOLERANCE", 1e-12)
    with pytest.raises(IrsimGymError, match="nothing is written: the graph of 'cluttered_room' differs by"):
        export_for_robot("cluttered_room", tmp_path / "out", levels=2)
    assert not (tmp_path / "out").exists()


def test_what_a_task_predicts_is_left_to_the_graph(tmp_path: Path) -> None:
    late = {"predict": "0.3", "disturbances": "latency:time=0.3"}
    found = export_for_robot(
        "cluttered_room", tmp_path / "out", request=ScenarioRequest("cluttered_room", parameters=late)
    )
    assert found.difference <= 1e-5
    assert found.contract.predict == 0.0
    assert found.contract.results is not None
    assert found.contract.results.success > 0.9


def test_a_latency_of_the_scenario_delays_a_predicting_policy_once(tmp_path: Path) -> None:
    data = yaml.safe_load(Path(find("cluttered_room")).read_text(encoding="utf-8"))
    data["robot"][0]["disturbances"] = [{"name": "latency", "time": 0.3}]
    file = tmp_path / "late.yaml"
    file.write_text(yaml.safe_dump(data), encoding="utf-8")
    asked = ScenarioRequest(str(file))
    late = export_for_robot("cluttered_room", tmp_path / "out", predict=0.3, request=asked, levels=20).contract
    assert late.results.success > 0.9
    again, _ = fit(tmp_path / "out", [Variant("more beams", {"beams": 200})], levels=20)
    assert again.results == late.results


def test_a_contract_has_the_curves_that_hold_for_its_graph(tmp_path: Path) -> None:
    """Those of a policy that is told its latency do not hold for a graph without prediction, others do."""
    own = export_for_robot("cluttered_room_robot", tmp_path / "own", levels=2)
    card = read_policy(shelf_file("cluttered_room_robot")).card
    assert card is not None
    assert set(card.robustness) - set(own.contract.robustness) == {"latency", "all"}
    text = (own.folder / "README.md").read_text(encoding="utf-8").replace("\n", " ")
    assert f"It loses 5 points at: {curves_text(own.contract.robustness)}." in text
    late = export_for_robot("cluttered_room", tmp_path / "late", levels=2, predict=0.3)
    assert late.contract.robustness == {}
    assert "5 points" not in (late.folder / "README.md").read_text(encoding="utf-8")


def test_an_export_is_not_replaced(exported: RobotExport) -> None:
    with pytest.raises(IrsimGymError, match=r"holds policy\.onnx already"):
        export_for_robot("cluttered_room", exported.folder, levels=1)


def test_the_command_says_what_it_wrote(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "export", "cluttered_room", "--out", tmp_path / "robot", "--levels", "2") == 0
    said = capsys.readouterr().out
    assert "needs scan, odometry" in said
    assert "commands of 2 levels differ by" in said


def test_commands_under_way_act_one_after_another() -> None:
    assert pending_spans(0.3, 0.1) == pytest.approx([0.1, 0.1, 0.1])
    assert pending_spans(0.25, 0.1) == pytest.approx([0.05, 0.1, 0.1])
    assert pending_spans(0.0, 0.1) == []


def test_a_prediction_is_what_the_robot_sees_when_it_is_there() -> None:
    """Commands of 0.3 s, known beforehand, among standing discs: the predicted pose and scan are those of later."""
    scanner = {"name": "lidar2d", "number": 181, "angle_range": 2 * np.pi, "range_max": 5, "offset": [0.1, 0, 0.2]}
    robot = {"kinematics": {"name": "diff"}, "state": [3, 3, 0.5], "goal": [6, 6], "sensors": [scanner]}
    discs = {"number": 2, "shape": {"name": "circle", "radius": 0.5}, "state": [[5, 4, 0], [2, 5, 0]]}
    wall = {"shape": {"name": "linestring", "vertices": [[0, 0], [7, 0], [7, 7], [0, 7], [0, 0]]}}
    limits = {"vel_min": [-1, -1.5], "vel_max": [1, 1.5]}
    world = {"width": 7, "height": 7, "step_time": 0.1}
    scenario = load_scenario({"world": world, "robot": {**robot, **limits}, "obstacle": [discs, wall]})
    task = load_task(scenario, {"name": "blank", "observations": ["scan"]})
    played = Episodes(compile(scenario, 1, agents=task.agents), task)
    played.begin(np.zeros(1, np.int64), np.zeros(1, np.int64))
    graph = Graph()
    later, _ = predicted(robot_values(graph, played, graph.input("action", np.float32, 2)), played, [0.1] * 3)
    graph.output("ranges_then", later.ranges, 181)
    graph.output("pose_then", later.pose, 3)
    session = onnxruntime.InferenceSession(graph.model("prediction").SerializeToString())
    commands = np.array([[[1.0, 1.0], [0.8, -0.5], [1.0, 1.2]]])
    now = measured(played)
    ranges, pose = session.run(None, {**{name: now[name] for name in ("ranges", "pose")}, "pending": commands})
    for command in commands[0]:
        played.step((command / [1.0, 1.5]).reshape(1, 1, 2))
    then = measured(played)
    np.testing.assert_allclose(pose, then["pose"], atol=0.02)
    off = np.abs(ranges - then["ranges"])
    assert np.median(off) < 0.03
    assert np.mean(off < 0.25) > 0.95


@pytest.mark.slow
@pytest.mark.parametrize(("seconds", "least"), [(0.0, 0.97), (0.3, 0.97), (0.5, 0.95)])
def test_a_predictor_makes_up_for_late_commands(seconds: float, least: float) -> None:
    """Without it, 77 % and 44 % of the levels are solved at 0.3 and 0.5 s."""
    policy = read_policy(shelf_file("cluttered_room"))
    played = Perceived(ScenarioRequest("cluttered_room").episodes(100)).of(SavedPolicy(policy))
    graph = policy_graph(policy, played, "cluttered_room", predict=seconds)
    rows = evaluate(DelayedPolicy(GraphPolicy(graph), round(seconds / 0.1)), played, 400, "test")
    assert sum(row.outcome == "success" for row in rows) >= least * 400
