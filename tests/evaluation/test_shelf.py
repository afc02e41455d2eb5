"""Policies on the shelf: what they are called, what their cards say, and that both are true."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import pickle
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import run
from pydantic import TypeAdapter
from robustness_rows import made

import irsim_gym
from irsim_gym.envs.parts.spaces import observation_layout
from irsim_gym.errors import IrsimGymError, UnknownNameError
from irsim_gym.evaluation import Robustness
from irsim_gym.evaluation.byte_planes import from_planes
from irsim_gym.evaluation.comparison.evaluate import evaluate_policies
from irsim_gym.evaluation.curves.factors import chosen_factors
from irsim_gym.evaluation.policies.perception import perceived_task, perception_of
from irsim_gym.evaluation.policies.policy import percepts
from irsim_gym.evaluation.policies.reference_policies import policy_kinds
from irsim_gym.evaluation.protocol.tables import plain
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.evaluation.requests.remembered import changes_since, remembered_parameters
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.cards import CURVES, CardResult, PolicyCard, card_file
from irsim_gym.evaluation.saved_policies.checkpoint_files import list_checkpoints, load_progress
from irsim_gym.evaluation.saved_policies.policies import (
    SavedPolicy,
    UnfitPolicyError,
    load_policy,
    policy_digest,
    policy_names,
)
from irsim_gym.evaluation.saved_policies.shelf import ShelfPolicy, card_of, shelf_file, shelf_files
from irsim_gym.evaluation.saved_policies.shelf_tables import curves_text
from irsim_gym.evaluation.saved_policies.snapshot import take_snapshot
from irsim_gym.scenario import load_scenario
from irsim_gym.tasks import load_task
from irsim_gym.training.export.exporting import MEASURED, export
from irsim_gym.training.requests.train import train
from irsim_gym.training.runs.fine_tuning import load_origin
from irsim_gym.training.settings.hyperparameters import Hyperparameters
from irsim_gym.training.settings.run import Run, Settings

AGENTS = Path(__file__).parents[2] / "agents"
ORIGINALS = {
    "circle_swap": "circle_swap_seed_3",
    "cluttered_room": "cluttered_room_seed_1",
    "cluttered_room_images": "cluttered_room_images_seed_100",
    "dense_room": "dense_room_seed_4",
    "random_swap": "random_swap_seed_2",
}
"""Files in agents/policies that policies on the shelf were made of."""
ROUNDING = {"cluttered_room_images": 5e-6}
"""How far PyTorch is off in single precision where it is more than 1e-6."""
LEVELS = 200
FAST = {"cluttered_room", "dense_room"}
"""Policies whose 200 levels take a second; teams and pictures take longer."""


def card(name: str) -> PolicyCard:
    found = card_of(name)
    assert found is not None
    return found


def figures(name: str, result: CardResult, levels: int) -> Any:
    """Return the share of levels that a policy solves under the conditions of one of its card's figures.

    What ``export`` plays itself ends as in training; tables of ``evaluate`` are by the scenario's own task.
    """
    where = card(name).scenario
    scenario = result.scenario or where.name
    task = where.task if result.source == MEASURED else None
    asked = ScenarioRequest(scenario, task, result.team, result.parameters)
    found: Any = evaluate_policies(asked, [name], levels=levels, split=result.split, references=False).summaries[0]
    return found.cooperative_success if result.team else found.success


@pytest.mark.parametrize("name", [n if n in FAST else pytest.param(n, marks=pytest.mark.slow) for n in shelf_files()])
def test_a_policy_is_as_good_as_its_card_says(name: str) -> None:
    """The 95 % intervals of the card and of its first 200 levels have a part in common."""
    for result in card(name).results:
        found = figures(name, result, min(LEVELS, result.levels))
        assert found.low <= result.success.high, result
        assert found.high >= result.success.low, result


@pytest.mark.parametrize("name", shelf_files())
def test_a_card_belongs_to_its_policy_and_its_scenario(name: str) -> None:
    found, file = card(name), shelf_file(name)
    assert found.name == name
    assert (found.size, found.sha256) == (file.stat().st_size, hashlib.sha256(file.read_bytes()).hexdigest())
    where = found.scenario
    assert where.sha256 == take_snapshot(where.name, where.task, where.parameters).digest, "export the policy anew"
    observed = irsim_gym.load_policy(name).observation_space.shape
    assert observed is not None
    assert sum(np.prod(term.shape) for term in found.observation) == np.prod(observed)
    assert found.training.seed in found.training.seeds
    policy = load_policy(name)
    assert isinstance(policy, SavedPolicy)
    assert policy.perception is not None
    scenario = load_scenario(where.name, where.parameters)
    task = load_task(scenario, where.task, team=where.team is not None)
    # Options that are newer than the file have their defaults.
    assert perception_of(perceived_task(scenario, task, policy.perception)) == perception_of(task)
    assert name not in policy_kinds()


@pytest.mark.parametrize("file", sorted((AGENTS / "shelf" / CURVES).glob("*.json")), ids=lambda file: file.stem)
def test_curves_are_of_policies_and_factors_as_they_are(file: Path) -> None:
    record = TypeAdapter(Robustness).validate_python(json.loads(file.read_text()))
    for factor in chosen_factors(list(record.factors)):
        assert record.played[f"factor {factor.name}"] == f"{'; '.join(factor.perturb)}, noise {factor.noise:g}"
    lost = json.loads(file.read_text())["lost_5_points_at"]
    for name in record.policies:
        assert record.played[f"policy {name}"] == card(name).sha256
        assert "latency" in record.factors
        for factor, unit in record.factors.items():
            curve = card(name).robustness[factor]
            assert (curve.unit, curve.played_to) == (unit, record.curve(factor, name)[-1].strength)
            assert curve.lost_at == lost[name][factor] == plain(record.lost_at(factor, name))


def test_a_card_is_completed_with_the_curves_of_its_own_policy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for file in (shelf_file("cluttered_room"), card_file(shelf_file("cluttered_room"))):
        shutil.copy(file, tmp_path)
    policy = tmp_path / "cluttered_room.npz"

    def curves(file: str, scenario: str, digest: str, *shares: int) -> Any:
        rows = [*made("mine", *shares), *made("none", 3, 0)]
        played = {"scenario": scenario, "levels": 100, "split": "test", "policy none": "0", "policy mine": digest}
        Robustness(played, rows).write(tmp_path)
        (tmp_path / CURVES).mkdir(exist_ok=True)
        (tmp_path / "robustness.json").rename(tmp_path / CURVES / file)
        found = card_of(policy)
        assert found is not None
        return found.robustness

    own = card("cluttered_room").sha256
    assert curves("a.json", "cluttered_room", "another", 99, 97, 82) == {}
    assert curves("a.json", "dense_room", own, 99, 97, 82) == {}
    assert curves("a.json", "cluttered_room (disturbances = 'slip')", own, 99, 97, 82) == {}
    assert curves("a.json", "cluttered_room", own, 3, 0) == {}  # no 5 points to lose
    assert curves_text(curves("a.json", "cluttered_room", own, 99, 97, 99)) == "latency > 0.4 s"
    assert curves_text(curves("b.json", "cluttered_room (n = 3)", own, 99, 97, 82)) == "latency 0.24 s"
    assert run(monkeypatch, "policies", "show", policy) == 0
    assert "5 points of success are lost at: latency 0.24 s\n" in capsys.readouterr().out
    assert run(monkeypatch, "policies", "show", policy, "--json") == 0
    shown = json.loads(capsys.readouterr().out)["robustness"]["latency"]
    levels = {"unit": "s", "played_to": 0.4, "levels": 100, "split": "test"}
    assert shown == {"5 points lost at": pytest.approx(0.24), **levels}
    (tmp_path / CURVES / "b.json").write_text("{}")
    with pytest.raises(IrsimGymError, match=r"b\.json is no record of robustness: .*played"):
        card_of(policy)


@pytest.mark.parametrize("name", ORIGINALS)
def test_figures_are_those_of_the_committed_results(name: str) -> None:
    seed = f"seed_{card(name).training.seed}"
    for result in card(name).results:
        data = json.loads((AGENTS / "results" / result.source).read_text())
        rows = data["policies"] if "policies" in data else [one["test"] for one in data["seeds"]]
        if result.team:
            rows = [row[f"n_robots={result.parameters['n_robots']}"] for row in rows]
        own = next(row for row in rows if row["policy"] == seed)
        assert result.success.model_dump() == own["cooperative_success" if result.team else "success"]


@pytest.mark.parametrize(("name", "original"), ORIGINALS.items())
def test_it_acts_as_the_policy_that_it_was_made_of(name: str, original: str) -> None:
    where = card(name).scenario
    chosen: dict[str, Any] = {"parameters": where.parameters, "team": where.team is not None, "task": where.task}
    episodes = make_episodes(where.name, n_worlds=8, **chosen)
    worlds = np.arange(8)
    shelf, saved = load_policy(name), load_policy(AGENTS / "policies" / f"{original}.zip")
    episodes.begin(worlds, worlds, "test")
    for policy in (shelf, saved):
        policy.begin(episodes, worlds, worlds)
    for _ in range(25):
        acted = shelf.act(episodes, worlds)
        np.testing.assert_allclose(acted, saved.act(episodes, worlds), atol=ROUNDING.get(name, 1e-6))
        episodes.step(acted.reshape(8, episodes.n_agents, -1), worlds)


def test_it_predicts_as_models_of_stable_baselines_do() -> None:
    policy = irsim_gym.load_policy("cluttered_room")
    env = irsim_gym.make("cluttered_room")
    observation, _ = env.reset(seed=4)
    action, state = policy.predict(observation, deterministic=True)
    assert state is None
    assert env.action_space.contains(action)
    several, _ = policy.predict(np.stack([observation] * 3))
    assert several.shape == (3, 2)
    np.testing.assert_allclose(several, np.stack([action] * 3), atol=1e-12)
    with pytest.raises(ValueError, match="deterministic=True"):
        policy.predict(observation, deterministic=False)
    with pytest.raises(ValueError, match=r"observations of shape \(88,\), got \(87,\)"):
        policy.predict(observation[1:])
    found = irsim_gym.evaluate("cluttered_room", policy, levels=5, references=False)
    assert [summary.policy for summary in found.summaries] == ["shelfpolicy"]
    assert policy.observation_space.shape == env.observation_space.shape
    env.close()


def test_it_needs_no_pytorch() -> None:
    code = (
        "import sys, numpy, irsim_gym\n"
        "policy = irsim_gym.load_policy('cluttered_room')\n"
        "action, _ = policy.predict(numpy.zeros(policy.observation_space.shape, numpy.float32))\n"
        "print(action.shape, [name for name in ('torch', 'stable_baselines3', 'numba') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout == "(2,) []\n", done.stderr


class Dangerous:
    def __reduce__(self) -> tuple[Any, ...]:
        return print, ("code of the file runs",)


def test_no_code_of_a_file_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "bad.npz"
    np.savez(file, form=np.array([Dangerous()], object))
    with pytest.raises(IrsimGymError, match=r"no policy of the shelf: form\.npy must hold numbers or text, got object"):
        load_policy(file)
    file.write_bytes(pickle.dumps(Dangerous()))
    with pytest.raises(IrsimGymError, match="no policy of the shelf"):
        load_policy(file)
    assert capsys.readouterr().out == ""


def with_form(name: str, **changed: Any) -> io.BytesIO:
    """Return a shipped policy's file with another description."""
    with np.load(shelf_file(name)) as archive:
        arrays = dict(archive)
    form = {**json.loads(arrays.pop("form").item()), **changed}
    content = io.BytesIO()
    np.savez(content, form=np.array(json.dumps(form)), **arrays)
    return content


@pytest.mark.parametrize(("name", "number"), [("cluttered_room_images", 1), ("dense_room_memory", 2)])
def test_files_of_earlier_formats_are_read(name: str, number: int, tmp_path: Path) -> None:
    """They have each array under its own name."""
    with np.load(shelf_file(name)) as archive:
        form = json.loads(archive["form"].item())
        arrays = from_planes(form.pop("layout"), archive["planes"])
    file = tmp_path / "earlier.npz"
    np.savez_compressed(file, form=np.array(json.dumps({**form, "format": number})), **arrays)
    earlier, now = irsim_gym.load_policy(file), irsim_gym.load_policy(name)
    seen = now.observation_space.sample()
    np.testing.assert_array_equal(earlier.predict(seen)[0], now.predict(seen)[0])


def test_files_of_other_versions_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "later.npz"
    for changed, said in (
        ({"format": 4}, "its format is 4, and this version of irsim_gym reads 1 to 3"),
        ({"trunk": [{"kind": "lineer"}]}, "no step of a network is named 'lineer' \\(did you mean 'linear'"),
        ({"output": "soft"}, "output must be one of clip, squash, argmax, got 'soft'"),
    ):
        file.write_bytes(with_form("cluttered_room", **changed).getvalue())
        with pytest.raises(IrsimGymError, match=said):
            irsim_gym.load_policy(file)
    card_file(file).write_text('{"name": 3}')
    file.write_bytes(shelf_file("cluttered_room").read_bytes())
    with pytest.raises(IrsimGymError, match=r"later.json is no policy card: name: .*; scenario: Field required"):
        irsim_gym.load_policy(file)


DAMAGED: dict[str, dict[str, Any]] = {
    "planes that are no stream of zlib": {"planes": np.full(100, 255, np.uint8)},
    "no planes": {"planes": None},
    "text that is no JSON": {"form": np.array(b"{")},
    "a list": {"form": np.array(b"[]")},
    "numbers": {"form": np.array([1, 2])},
}


@pytest.mark.parametrize("arrays", DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_file_is_named(arrays: dict[str, Any], tmp_path: Path) -> None:
    file = tmp_path / "bad.npz"
    with np.load(shelf_file("cluttered_room")) as archive:
        content = {name: array for name, array in {**archive, **arrays}.items() if array is not None}
    np.savez(file, **content)
    with pytest.raises(IrsimGymError, match=r"bad.npz is no policy of the shelf: ."):
        irsim_gym.load_policy(file)


@pytest.mark.parametrize(
    "changed",
    [
        {"parts": [1]},
        {"trunk": 3},
        {"observation": None},
        {"action": {"n": -1}},
        {"action": {"n": 1}, "output": "argmax"},
        {"trunk": []},
        {"parts": {"": [{"kind": "linear"}]}, "trunk": []},
        {"format": None},
        {"layout": [["weight", "O", [3]]]},
    ],
    ids=str,
)
def test_a_description_of_another_form_is_named(changed: dict[str, Any], tmp_path: Path) -> None:
    """Also where only the arrays show that it is another network's."""
    file = tmp_path / "bad.npz"
    file.write_bytes(with_form("cluttered_room", **changed).getvalue())
    with pytest.raises(IrsimGymError, match=r"bad.npz is no policy of the shelf: ."):
        irsim_gym.load_policy(file)


def test_damaged_bytes_never_raise_anything_else(tmp_path: Path) -> None:
    """Each damage is refused, or it is in bytes that nothing reads."""
    file, whole, random = tmp_path / "bad.npz", shelf_file("dense_room_memory").read_bytes(), np.random.default_rng(3)
    for _ in range(60):
        content = bytearray(whole)
        for place in random.integers(0, len(whole), 3):
            content[place] ^= int(random.integers(1, 256))
        file.write_bytes(bytes(content[: random.integers(len(whole) // 2, 2 * len(whole))]))
        with contextlib.suppress(IrsimGymError):
            irsim_gym.load_policy(file)
    with pytest.raises(IrsimGymError, match=r"gone.npz is no policy of the shelf: no such file"):
        irsim_gym.load_policy(tmp_path / "gone.npz")


def test_a_card_of_another_file_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "mine.npz"
    shutil.copy(shelf_file("cluttered_room"), file)
    shutil.copy(card_file(shelf_file("dense_room")), card_file(file))
    with pytest.raises(IrsimGymError, match=r"mine\.json is no card of .*mine\.npz: its sha256 is that of another"):
        irsim_gym.load_policy(file)
    unrecorded = {**json.loads(card_file(file).read_text()), "sha256": ""}
    card_file(file).write_text(json.dumps(unrecorded))
    found = irsim_gym.load_policy(file).card
    assert found is not None
    assert found.name == "dense_room"


def test_a_run_without_a_policy_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("runs/a").mkdir(parents=True)
    Path("mine").mkdir()
    for source in ("runs/a/policy.zip", "runs/a", Path("runs/a"), "policy.zip", "mine"):
        with pytest.raises(IrsimGymError, match=f"no policy at {source}"):
            irsim_gym.load_policy(source)


def test_a_state_of_another_number_of_observations_is_refused() -> None:
    policy = irsim_gym.load_policy("jaxnav_four")
    shape, size = policy.observation_space.shape, policy.memory_shape
    assert shape is not None
    assert size is not None
    seen = np.zeros((3, *shape), np.float32)
    _, one = policy.predict(seen[0])
    _, three = policy.predict(seen)
    assert one is not None
    assert three is not None
    policy.predict(seen, three)
    said = rf"for 3 observations, state must hold one array of shape \(1, 3, {size[2]}\), got "
    for state, got in (
        (one, rf"\(1, 1, {size[2]}\)"),
        ((three[0][0],), rf"\(3, {size[2]}\)"),
        ((*three, *three), r"\(1, 3"),
        ((), "none"),
    ):
        with pytest.raises(ValueError, match=said + got):
            policy.predict(seen, state)


def test_an_observation_of_other_parts_is_refused() -> None:
    """The message gives shapes, not the bounds of each number."""
    lone = irsim_gym.load_policy("cluttered_room")
    with pytest.raises(ValueError, match=r"^the policy was trained with observations of shape \(88,\), got a dict$"):
        lone.predict({"scan": np.zeros(88)})
    several = two_parts()
    assert several.predict({"a": np.ones(3), "b": np.ones(2)})[0].tolist() == [5.0]
    shapes = r"a shape \(3,\), b shape \(2,\)"
    with pytest.raises(ValueError, match=rf"^the observation has no b; the policy was trained with {shapes}$"):
        several.predict({"a": np.ones(3)})
    with pytest.raises(ValueError, match=rf"^the policy was trained with observations of {shapes}, got an array$"):
        several.predict(np.ones(5))


def two_parts() -> ShelfPolicy:
    """Return a policy of an observation with two parts, whose action is the sum of all numbers."""
    sizes = {"observation/a": 3, "observation/b": 2, "action": 1}
    bounds = {f"{name}/low": np.full(n, -9.0, np.float32) for name, n in sizes.items()}
    bounds |= {f"{name}/high": np.full(n, 9.0, np.float32) for name, n in sizes.items()}
    arrays = {**bounds, "trunk/0/weight": np.ones((1, 5)), "trunk/0/bias": np.zeros(1)}
    kinds: dict[str, Any] = {"observation": {"a": "float32", "b": "float32"}, "action": {"dtype": "float32"}}
    return ShelfPolicy({**kinds, "output": "clip", "parts": {"a": [], "b": []}, "trunk": [{"kind": "linear"}]}, arrays)


def test_names_on_the_shelf_are_policies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert isinstance(load_policy("cluttered_room"), SavedPolicy)
    assert policy_names(["cluttered_room", "a/cluttered_room.npz", "dash"]) == [
        "cluttered_room-1",
        "cluttered_room-2",
        "dash",
    ]
    assert policy_digest("cluttered_room") == card("cluttered_room").sha256
    with pytest.raises(IrsimGymError, match="no policy named 'cluttered_rom' \\(did you mean 'cluttered_room'"):
        load_policy("cluttered_rom")
    with pytest.raises(UnknownNameError, match="no policy named 'dash' on the shelf"):
        irsim_gym.load_policy("dash")
    with pytest.raises(IrsimGymError, match="holds an actor without a critic"):
        load_origin("cluttered_room")


def test_a_name_with_two_meanings_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cluttered_room").mkdir()
    with pytest.raises(IrsimGymError, match=r"a file or folder here: write \./cluttered_room for that, or /.*npz"):
        load_policy("cluttered_room")
    with pytest.raises(IrsimGymError, match="no policy at cluttered_room"):
        load_policy(Path("cluttered_room"))
    (tmp_path / "cluttered_room").rmdir()
    monkeypatch.setattr(
        "irsim_gym.evaluation.saved_policies.policies.shelf_files", lambda: {"dash": tmp_path / "dash.npz"}
    )
    with pytest.raises(IrsimGymError, match="'dash' is a policy on the shelf, and a behavior: give that another name"):
        load_policy("dash")


def test_a_policy_observes_in_another_task_what_it_was_trained_with() -> None:
    found = evaluate_policies(ScenarioRequest("circle_swap"), ["cluttered_room"], levels=1, references=False)
    assert found.observes == {"cluttered_room": ["scan", "goal", "last_action", "free_travel", "goal_record", "trail"]}


def test_a_policy_is_refused_where_it_would_observe_something_else() -> None:
    """Without a scan it would see the nearest bodies and a route, which are other numbers."""
    robot = {"kinematics": {"name": "diff"}, "state": [1, 1, 0], "goal": [5, 5, 0]}
    with pytest.raises(UnfitPolicyError, match="cluttered_room: the policy was trained with observations of shape"):
        evaluate_policies(ScenarioRequest({"robot": robot}), ["cluttered_room"], levels=1, references=False)


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A short training of a team, with normalised observations."""
    tiny = {"n_timesteps": 256, "n_envs": 4, "n_steps": 16, "batch_size": 32, "n_epochs": 1}
    wanted = Hyperparameters.from_plain({**tiny, "normalize": True, "team": "episode"})
    settings = Settings("circle_swap", "ppo", 7, None, wanted, {"n_robots": 3})
    return train(settings, tmp_path_factory.mktemp("team") / "run")


def test_a_run_becomes_a_policy_of_the_shelf(
    trained: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["policies", "export", trained.folder, "trio", "--out", tmp_path]
    assert run(monkeypatch, *words, "--levels", 3, "--weakness", "Hardly trained.") == 0
    file = tmp_path / "trio.npz"
    assert capsys.readouterr().out == f"policy: {file}\ncard: {tmp_path / 'trio.json'}\n"
    found = card_of(file)
    assert found is not None
    assert found.scenario.sha256 == take_snapshot("circle_swap", None, {"n_robots": 3}).digest
    assert (found.scenario.name, found.scenario.parameters["n_robots"]) == ("circle_swap", 3)
    assert (found.training.seed, found.training.steps, found.training.seeds) == (7, 384, (7,))
    assert (found.results[0].levels, found.results[0].team, found.weaknesses) == (3, True, ("Hardly trained.",))
    assert str(tmp_path) not in (tmp_path / "trio.json").read_text()
    first = file.read_bytes()
    assert run(monkeypatch, *words) == 1
    assert "trio.npz exists" in capsys.readouterr().err
    assert run(monkeypatch, *words, "--overwrite", "--levels", 1) == 0
    assert file.read_bytes() == first
    file.unlink()
    kept = (tmp_path / "trio.json").read_bytes()
    assert run(monkeypatch, *words, "--levels", 1) == 1
    assert f"{tmp_path / 'trio.json'} exists: choose another name" in capsys.readouterr().err
    assert ((tmp_path / "trio.json").read_bytes(), file.exists()) == (kept, False)
    assert run(monkeypatch, *words, "--overwrite", "--levels", 1) == 0
    capsys.readouterr()
    assert run(monkeypatch, "policies", "show", file) == 0
    assert "network, observation: standardize\nnetwork, action: 64, tanh, 64, tanh, 2\n" in capsys.readouterr().out


def test_what_a_policy_was_trained_with_is_remembered(
    trained: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "policies", "export", trained.folder, "trio", "--out", tmp_path, "--levels", 1) == 0
    file = tmp_path / "trio.npz"
    assert remembered_parameters("circle_swap", [file])["n_robots"] == 3
    assert remembered_parameters("random_swap", [file]) == {}
    assert changes_since("circle_swap", file) == []
    changed = json.loads(card_file(file).read_text())
    changed["scenario"]["sha256"] = "0" * 64
    card_file(file).write_text(json.dumps(changed))
    assert changes_since("circle_swap", file) == ["its hash is not that on the card"]
    assert run(monkeypatch, "evaluate", "circle_swap", file, "--team", "--levels", 1) == 0
    said = capsys.readouterr().err
    assert f"circle_swap has changed since {file} was trained: its hash is not that on the card\n" in said


SINGLE = {
    "cluttered_room": {}, "rooms": {}, "maze": {}, "cellular_cave": {}, "jaxnav_single": {},
    "crowd_nav": {"goal_change": 0.5},
}  # fmt: skip
"""Scenarios of tier core with one robot, and their parameters."""


@pytest.mark.parametrize("name", SINGLE)
def test_the_general_policy_drives_every_single_robot_of_core(name: str) -> None:
    own: dict[str, Any] = SINGLE[name]
    episodes = make_episodes(name, n_worlds=2, parameters=own, task="general_navigation")
    worlds, policy = np.arange(2), load_policy("general")
    assert isinstance(policy, SavedPolicy)
    assert policy.perception is not None
    asked = perceived_task(episodes.simulation.scenario, episodes.task, policy.perception)
    assert perception_of(asked) == perception_of(episodes.task)
    episodes.begin(worlds, worlds, "test")
    policy.begin(episodes, worlds, worlds)
    bodies = list(episodes.task.agents)
    before = episodes.simulation.state.pose[:, bodies, :2].copy()
    for _ in range(10):
        episodes.step(policy.act(episodes, worlds).reshape(2, 1, 2), worlds)
    assert not np.array_equal(episodes.simulation.state.pose[:, bodies, :2], before)


def test_the_settings_of_a_run_are_not_replaced_by_a_card(trained: Run, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    shutil.copytree(trained.folder, folder)
    for overwrite, said in ((False, "choose another name or folder"), (True, "is no policy card")):
        with pytest.raises(IrsimGymError, match=rf"config\.json.*{said}"):
            export(folder, "config", folder, levels=1, overwrite=overwrite)
    assert (folder / "config.json").read_bytes() == trained.config.read_bytes()


def test_a_card_is_written_after_its_policy(trained: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """If the disk is full in between, the old card does not pass for that of the new policy."""
    file = export(trained.folder, "trio", tmp_path, levels=1)
    changed = {**json.loads(card_file(file).read_text()), "sha256": "0" * 64}
    card_file(file).write_text(json.dumps(changed))

    def full(*args: object) -> None:
        raise OSError("no space left")

    monkeypatch.setattr("irsim_gym.training.export.exporting.write_json", full)
    file.write_bytes(b"old")
    with pytest.raises(OSError, match="no space left"):
        export(trained.folder, "trio", tmp_path, levels=1, overwrite=True)
    assert file.read_bytes() != b"old"
    with pytest.raises(IrsimGymError, match=r"trio\.json is no card of .*trio\.npz"):
        irsim_gym.load_policy(file)


def test_an_exported_run_drives_as_the_run(trained: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert run(monkeypatch, "policies", "export", trained.folder, "trio", "--out", tmp_path, "--levels", 1) == 0
    episodes = make_episodes("circle_swap", n_worlds=2, parameters={"n_robots": 3}, team=True)
    worlds = np.arange(2)
    episodes.begin(worlds, worlds, "dev")
    policy, original = irsim_gym.load_policy(tmp_path / "trio.npz"), load_policy(trained.folder)
    seen = observation_layout(episodes).formed(percepts(episodes, worlds))
    assert not isinstance(seen, dict)
    original.begin(episodes, worlds, worlds)
    expected = original.act(episodes, worlds).reshape(6, 2)
    np.testing.assert_allclose(policy.predict(seen)[0], expected, atol=1e-6)
    for source in (trained.folder, str(trained.policy)):
        loaded = irsim_gym.load_policy(source)
        np.testing.assert_array_equal(loaded.predict(seen)[0], policy.predict(seen)[0])
        assert loaded.perception == policy.perception
    monkeypatch.chdir(tmp_path)
    assert run(monkeypatch, "policies", "export", trained.folder, "here", "--levels", 1) == 0
    assert (tmp_path / "here.npz").is_file()


def test_a_checkpoint_is_exported_with_its_own_cost(trained: Run, tmp_path: Path) -> None:
    """Also of a run that is not finished, which has no policy of its own yet."""
    run_folder = tmp_path / "run"
    shutil.copytree(trained.folder, run_folder)
    first = list_checkpoints(run_folder / "checkpoints")[0]
    policy = first / "policy.zip"
    (run_folder / "policy.zip").unlink()
    with pytest.raises(IrsimGymError, match="is not finished: resume it"):
        export(run_folder, "whole", tmp_path, levels=1)
    files = [export(source, f"part{k}", tmp_path, levels=1) for k, source in enumerate((first, policy))]
    cards = [card_of(file) for file in files]
    assert [one.training.steps for one in cards if one is not None] == [load_progress(first).steps] * 2
    assert cards[0] is not None
    assert cards[0].scenario.name == "circle_swap"
    assert files[0].read_bytes() == files[1].read_bytes()


def test_what_cannot_be_exported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    zipped = AGENTS / "policies" / "dense_room_seed_0.zip"
    results = AGENTS / "results" / "cluttered_room.json"
    for words, said in (
        ((zipped, "dense"), "settings and the cost of the training"),
        ((zipped, "dash"), "'dash' is the name of a behavior"),
        ((zipped, "dense room"), "the name of a policy must consist of letters, digits and _"),
        (("dash", "mine"), "dash is a behavior, which has no weights"),
        ((shelf_file("cluttered_room"), "mine"), "is not a trained policy of Stable-Baselines3"),
        ((AGENTS / "policies" / "cluttered_room_images_seed_100.zip", "x", "--results", results), "has no row of its"),
        ((zipped, "dense", "--results", __file__), "is no file with figures of policies"),
    ):
        assert run(monkeypatch, "policies", "export", *words, "--out", tmp_path) == 1
        assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_shelf_is_listed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, "policies", "list") == 0
    said = capsys.readouterr().out
    assert all(name in said for name in shelf_files())
    assert "99.3 [99.1, 99.5]" in said
    assert run(monkeypatch, "policies", "show", "cluttered_room", "--json") == 0
    assert PolicyCard.model_validate_json(capsys.readouterr().out) == card("cluttered_room")
    assert run(monkeypatch, "policies", "show", "clutered_room") == 1
    assert "did you mean 'cluttered_room'" in capsys.readouterr().err
