"""One policy for several scenarios: worlds shared out, batches joined, runs resumed, curves by scenario."""

from __future__ import annotations

import io
import json
import pickle
import shutil
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
import yaml
from command_line import run as command
from rich.console import Console

from irsim_gym import sb3
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.comparison.evaluate import evaluate_policies
from irsim_gym.evaluation.requests.interruption import TrainingInterruptedError
from irsim_gym.evaluation.requests.remembered import remembered_parameters
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.cards import card_file
from irsim_gym.evaluation.saved_policies.policies import load_policy
from irsim_gym.evaluation.saved_policies.shelf import card_of, shelf_file
from irsim_gym.evaluation.saved_policies.shelf_tables import print_card
from irsim_gym.training.curves.score import combined, scenario_point
from irsim_gym.training.export.exporting import export
from irsim_gym.training.requests.train import train
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.runs.environment import build_environment
from irsim_gym.training.settings.hyperparameters import Hyperparameters
from irsim_gym.training.settings.mixture import MixturePart, read_part, shared_worlds
from irsim_gym.training.settings.run import Run, Settings

QUIET = Console(file=io.StringIO())
PPO: dict[str, Any] = {
    "n_timesteps": 768, "n_envs": 6, "n_steps": 16, "batch_size": 48, "n_epochs": 2, "checkpoint_every": 384,
    "policy_kwargs": {"net_arch": [16]},
}  # fmt: skip
CONFIGS = Path(__file__).parents[2] / "configs" / "scenarios"
TWO = (MixturePart("cluttered_room"), MixturePart("dense_room", share=2.0))


def settings(parts: tuple[MixturePart, ...] = TWO, **own: Any) -> Settings:
    first = parts[0]
    wanted = Hyperparameters.from_plain({**PPO, **own})
    return Settings(first.scenario, "ppo", 3, None, wanted, first.parameters, mixture=parts)


def both(**own: Any) -> dict[str, Any]:
    return {name: sb3.make_vec_env(name, n, seed=7, **own) for name, n in (("cluttered_room", 2), ("dense_room", 3))}


def test_what_stands_behind_a_scenarios_name() -> None:
    assert read_part("rooms") == MixturePart("rooms", {}, 1.0)
    assert read_part("rooms:share=0.5:n=3") == MixturePart("rooms", {"n": "3"}, 0.5)
    assert read_part("C:/my.yaml:n=3") == MixturePart("C:/my.yaml", {"n": "3"}, 1.0)
    for wrong in ("rooms:n=1:m", "rooms:n=1:n=2", "rooms:share=0", "rooms:share=many", "rooms:share=inf"):
        with pytest.raises(IrsimGymError, match=wrong):
            read_part(wrong)


@pytest.mark.parametrize(
    ("shares", "n_worlds", "wanted"),
    [([1, 1], 8, [4, 4]), ([1, 3], 8, [2, 6]), ([1, 100], 8, [1, 7]), ([1, 1, 1], 8, [3, 3, 2]), ([1, 1], 2, [1, 1])],
)
def test_worlds_are_shared_out_by_weight_and_each_gets_one(
    shares: list[float], n_worlds: int, wanted: list[int]
) -> None:
    assert shared_worlds(shares, n_worlds) == wanted


def test_fewer_worlds_than_scenarios_are_refused() -> None:
    with pytest.raises(IrsimGymError, match=r"mixture of 3 scenarios.*n_envs is 2"):
        shared_worlds([1, 1, 1], 2)


def test_each_slot_steps_as_in_its_own_batch() -> None:
    mixed, alone = sb3.MixtureVecEnv(both()), both()
    assert mixed.num_envs == 5
    np.testing.assert_array_equal(mixed.reset(), np.concatenate([env.reset() for env in alone.values()]))
    random, names = np.random.default_rng(1), []
    for _ in range(150):
        actions = random.uniform(-1.0, 1.0, (5, 2)).astype(np.float32)
        seen, paid, dones, infos = mixed.step(actions)
        steps = [env.step(part) for env, part in zip(alone.values(), (actions[:2], actions[2:]), strict=True)]
        for found, k in ((seen, 0), (paid, 1), (dones, 2)):
            np.testing.assert_array_equal(found, np.concatenate([step[k] for step in steps]))
        names += [(slot, info["scenario"]) for slot, info in enumerate(infos) if info]
    assert {(slot < 2, name) for slot, name in names} == {(True, "cluttered_room"), (False, "dense_room")}
    again = pickle.loads(pickle.dumps(mixed))
    np.testing.assert_array_equal(again.step(actions)[0], mixed.step(actions)[0])
    assert mixed.get_attr("max_steps", [1, 2]) == [one.get_attr("max_steps")[0] for one in alone.values()]
    mixed.set_attr("max_steps", 9, [2, 3, 4])
    assert mixed.get_attr("max_steps")[1:3] == [alone["cluttered_room"].get_attr("max_steps")[0], 9]
    assert len(mixed.reset_infos) == 5
    mixed.set_options([{"level": 4}] * 2 + [{"level": 5}] * 3)
    mixed.reset()
    assert [info["level"] for info in mixed.reset_infos] == [4, 4, 5, 5, 5]
    assert list(mixed.describe()) == ["cluttered_room", "dense_room"]
    mixed.close()


def test_what_differs_is_named() -> None:
    batches = both()
    wide = sb3.make_vec_env("dense_room", 1, task={"observations": [{"name": "scan", "sectors": 12}]})
    with pytest.raises(IrsimGymError, match=r"cluttered_room observes scan \(36\), where dense_room has scan \(12\)"):
        sb3.MixtureVecEnv({**batches, "dense_room": wide})
    more = sb3.make_vec_env("dense_room", 1, task={"observations": ["velocity"]})
    with pytest.raises(IrsimGymError, match=r"observes nothing more, where dense_room has velocity \(2\)"):
        sb3.MixtureVecEnv({**batches, "dense_room": more})
    chosen = sb3.make_vec_env("dense_room", 1, task={"action": "discrete"})
    with pytest.raises(IrsimGymError, match=r"cluttered_room acts by Box \(\(2,\)\), where dense_room has Discrete"):
        sb3.MixtureVecEnv({**batches, "dense_room": chosen})
    team = sb3.make_multi_agent_vec_env("random_swap", 1)
    with pytest.raises(IrsimGymError, match="is a WorldVecEnv, random_swap a TeamVecEnv"):
        sb3.MixtureVecEnv({**batches, "random_swap": team})
    with pytest.raises(IrsimGymError, match="at least one"):
        sb3.MixtureVecEnv({})


def test_components_may_differ_in_meaning() -> None:
    """The second one turns a robot on wheels, and moves another to its left; a column of ``own_body`` tells which."""
    names = ("cluttered_room", "crowd_nav")
    mixed = sb3.MixtureVecEnv({name: sb3.make_vec_env(name, 1, seed=0, task="general_navigation") for name in names})
    told = mixed.describe()
    seconds = [told[name].action.components[1].name for name in names]
    assert seconds == ["turn rate, positive to the left", "speed to the left"]
    assert mixed.reset()[:, 97].tolist() == [0.0, 1.0]


def test_teams_of_different_size_say_who_acted() -> None:
    parts = {str(n): sb3.make_multi_agent_vec_env("random_swap", 2, seed=0, n_robots=n) for n in (2, 3)}
    mixed = sb3.MixtureVecEnv(parts)
    model = sb3.MaskedPPO("MlpPolicy", mixed, n_steps=40, batch_size=80, n_epochs=1, seed=0)
    model.learn(400)
    assert all(part.leaves_out_waiting for part in parts.values())
    assert mixed.acted.shape == (10,)
    idle = [part.idle_share * part.num_envs for part in parts.values()]
    assert mixed.idle_share == pytest.approx(sum(idle) / 10)
    assert not hasattr(sb3.MixtureVecEnv(both()), "acted")


def test_figures_together_and_of_each() -> None:
    parts = {
        "a": {"levels": 10, "success": 0.5, "success_low": 0.2, "success_high": 0.8, "collision": 0.5},
        "b": {"levels": 10, "success": 0.9, "success_low": 0.6, "success_high": 1.0, "collision": 0.1},
    }
    point = {"steps": 3, "training_seconds": 1.0, "cpu_seconds": 2.0, **combined(parts)}
    assert (point["levels"], point["success"], point["collision"]) == (20, pytest.approx(0.7), pytest.approx(0.3))
    low, high = 0.481, 0.855  # Wilson's interval of 14 of 20
    assert (point["success_low"], point["success_high"]) == (
        pytest.approx(low, abs=1e-3),
        pytest.approx(high, abs=1e-3),
    )
    assert scenario_point(point, "b") == {"steps": 3, "training_seconds": 1.0, "cpu_seconds": 2.0, **parts["b"]}
    assert combined({"a": parts["a"]}) == parts["a"]


def weights(run: Run) -> torch.Tensor:
    model: Any = load_policy(run.policy).model  # type: ignore[union-attr]
    return torch.cat([value.flatten() for value in model.policy.state_dict().values()])


def test_a_resumed_mixture_equals_an_uninterrupted_one(tmp_path: Path, interrupt: Callable[[int, int], None]) -> None:
    asked = settings(normalize=True)
    env: Any = build_environment(asked)
    assert [part.num_envs for part in env.unwrapped.parts.values()] == [2, 4]
    env.close()
    whole = train(asked, tmp_path / "whole", console=QUIET)
    interrupt(300, signal.SIGINT)
    with pytest.raises(TrainingInterruptedError):
        train(asked, tmp_path / "parts", console=QUIET)
    assert Run(tmp_path / "parts").settings() == asked
    own = Run(tmp_path / "parts").own_settings()
    assert [Path(part.scenario).name for part in own.parts()] == ["cluttered_room.yaml", "dense_room.yaml"]
    torch.manual_seed(99)
    parts = train(asked, tmp_path / "parts", resume=True, console=QUIET)
    assert torch.equal(weights(whole), weights(parts))
    with pytest.raises(IrsimGymError, match="mixture"):
        train(settings((TWO[0], MixturePart("maze"))), tmp_path / "parts", console=QUIET)


def test_a_changed_scenario_of_a_mixture_is_told(tmp_path: Path) -> None:
    world = {"world": {"width": 5, "height": 5}, "robot": {"kinematics": {"name": "diff"}, "goal": [4, 4],
             "state": [1, 1, 0], "sensors": [{"name": "lidar2d", "number": 36}]}}  # fmt: skip
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump(world))
    asked = settings((TWO[0], MixturePart(str(file))), n_timesteps=96, checkpoint_every=96)
    run = train(asked, tmp_path / "run", console=QUIET)
    assert run.changes_in_others(asked) == []
    file.write_text(yaml.safe_dump({**world, "world": {"width": 6, "height": 5}}))
    assert run.changes_in_others(asked) == ["mine: world.width 5, now 6"]


def test_the_card_of_a_mixture_names_all_scenarios(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    parts = tuple(MixturePart(name, {"n_robots": n}) for name, n in (("random_swap", 3), ("circle_swap", 2)))
    run = train(settings(parts, team="episode", n_timesteps=96, checkpoint_every=96), tmp_path / "run", console=QUIET)
    file = export(run.folder, "both", tmp_path / "shelf", levels=2)
    card = card_of(file)
    assert card is not None
    assert [(one.name, one.parameters["n_robots"], one.share) for one in card.training.mixture] == [
        ("random_swap", 3, 1.0),
        ("circle_swap", 2, 1.0),
    ]
    played = [(result.scenario, result.parameters["n_robots"]) for result in card.results]
    assert played == [(None, 3), ("circle_swap", 2)]
    circle = ScenarioRequest("circle_swap", team=True)
    evaluate_policies(circle, [run.folder], levels=2, references=False, folder=tmp_path / "test")
    files = [tmp_path / "test" / "summary.json"]
    file = export(run.folder, "file", tmp_path / "shelf", results=files)
    print_card(str(file))
    told = capsys.readouterr().out
    assert "trained in random_swap (n_robots = 3), " in told
    assert ", circle_swap (n_robots = 2), as a team" in told
    assert "2 test levels of circle_swap (n_robots = " in told


@pytest.mark.slow
def test_the_command_line_trains_a_mixture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hp.yaml").write_text(yaml.safe_dump({"default": PPO}))
    asked = ["train", "--mixture", "cluttered_room", "dense_room:share=2"]
    assert command(monkeypatch, *asked, "--hyperparameters", "hp.yaml", "--dev-levels", "8") == 0
    folder = next(Path("runs").iterdir())
    assert folder.name.startswith("cluttered_room+dense_room-share=2-ppo".replace("+", "_"))
    point = json.loads((folder / "curve.json").read_text())["points"][-1]
    assert point["levels"] == 16
    assert point["success"] == pytest.approx((point["cluttered_room/success"] + point["dense_room/success"]) / 2)
    assert "dense_room: " in capsys.readouterr().out
    for scenario in ("cluttered_room", "dense_room"):
        told = command(monkeypatch, "evaluate", scenario, str(folder), "--levels", "4", "--out", f"test-{scenario}")
        assert told == 0


def test_seeds_of_a_mixture_are_summed_up_in_each_scenario(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hp.yaml").write_text(yaml.safe_dump({"default": {**PPO, "n_timesteps": 96}}))
    asked = ["train", "--mixture", "cluttered_room", "dense_room", "--seeds", "2", "--out", "all"]
    assert command(monkeypatch, *asked, "--hyperparameters", "hp.yaml", "--dev-levels", "4", "--test-levels", "4") == 0
    said = capsys.readouterr().out
    for name in ("cluttered_room", "dense_room"):
        found = json.loads(Path("all", name, "results.json").read_text())
        assert (found["scenario"], [seed["run"] for seed in found["seeds"]]) == (name, ["seed_0", "seed_1"])
        for seed in found["seeds"]:
            curve = json.loads(Path("all", seed["run"], "curve.json").read_text())["points"]
            assert seed["dev_success"] == curve[-1][f"{name}/success"]
            assert seed["test"]["success"]["count"] in range(5)
        assert (Path("all") / name / "test" / "summary.json").is_file()
        assert f"{name}: PPO, 4 test levels" in said


def test_what_does_not_go_with_a_mixture() -> None:
    with pytest.raises(IrsimGymError, match="--set is for one scenario"):
        TrainingRequest("cluttered_room", mixture=TWO, parameters={"n": 3}).settings()


def test_scenarios_that_observe_otherwise_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    """The room shows the same sizes in another code, the empty one has no lidar."""
    file = tmp_path / "coded.yaml"
    room = yaml.safe_load((CONFIGS / "dense_room.yaml").read_text())
    room["task"] = {**room.get("task", {}), "observations": [{"name": "scan", "code": "linear"}]}
    file.write_text(yaml.safe_dump(room))
    with pytest.raises(IrsimGymError, match=r"cluttered_room has scan.code inverse, .*coded.yaml linear; --task"):
        TrainingRequest("cluttered_room", mixture=(TWO[0], MixturePart(str(file)))).settings()
    with pytest.raises(
        IrsimGymError, match=r"cluttered_room has scan, free_travel, which empty_goal has not; .*no nearest_bodies"
    ):
        TrainingRequest("cluttered_room", mixture=(TWO[0], MixturePart("empty_goal"))).settings()


def test_names_are_short_and_differ() -> None:
    two = MixturePart("random_swap", {"n_robots": 2}), MixturePart("random_swap", {"n_robots": 3}), MixturePart("maze")
    assert settings(two).names == ("random_swap n_robots=2", "random_swap n_robots=3", "maze")
    assert settings((two[2], two[2])).names == ("maze", "maze-2")


def test_the_parameters_of_each_are_remembered(tmp_path: Path) -> None:
    parts = MixturePart("random_swap", {"n_robots": 2}), MixturePart("circle_swap", {"n_robots": 3})
    run = Run(tmp_path)
    run.begin(settings(parts, team="episode"))
    assert remembered_parameters("circle_swap", [tmp_path])["n_robots"] == 3
    assert remembered_parameters("random_swap", [tmp_path])["n_robots"] == 2


def test_a_scenario_with_several_values_in_a_mixture_is_not_remembered(tmp_path: Path) -> None:
    """Equal values are not ambiguous, in whichever part they stand."""
    twice = MixturePart("random_swap", {"n_robots": 5}), MixturePart("random_swap", {"n_robots": 3})
    for name, parts, found in (("two", twice, {}), ("one", (twice[1], twice[1]), {"n_robots": 3})):
        Run(tmp_path / name).begin(settings(parts, team="episode"))
        assert remembered_parameters("random_swap", [tmp_path / name]) == found


def test_a_card_remembers_the_parameters_of_each_scenario(capsys: pytest.CaptureFixture[str]) -> None:
    assert remembered_parameters("crowd_nav", ["general"]) == {"goal_change": 0.5}
    assert "crowd_nav (goal_change = 0.5), as in training" in capsys.readouterr().err
    assert remembered_parameters("irsim_gym/crowd_nav-v0", ["general"]) == {"goal_change": 0.5}
    assert remembered_parameters("parking", ["general"]) == {}


def test_a_card_remembers_nothing_of_a_scenario_with_several_values(tmp_path: Path) -> None:
    """The card of ``maze`` lists it with two shares of loops, neither of which is the default here."""
    file = tmp_path / "mazes.npz"
    shutil.copy(shelf_file("maze"), file)
    card = json.loads(card_file(shelf_file("maze")).read_text())
    parts = card["training"]["mixture"]
    assert [part["name"] for part in parts] == ["maze", "maze"]
    for loops, found in (((0.7, 0.0), {}), ((0.7, 0.7), {"loops": 0.7})):
        for part, value in zip(parts, loops, strict=True):
            part["parameters"] = {"loops": value}
        card["scenario"]["parameters"] = {"loops": loops[0]}
        card_file(file).write_text(json.dumps(card))
        assert remembered_parameters("maze", [file]) == found
