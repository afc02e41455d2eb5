"""A valid file of each kind that the package reads, how it is read, and how it is damaged."""

from __future__ import annotations

import dataclasses
import json
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
from damage import Random, broken_archive, broken_bytes, broken_json, broken_text

import irsim_gym
from irsim_gym.evaluation.comparison.demonstrations import Demonstrations, save_demonstrations
from irsim_gym.evaluation.levels.certificate import read_certificate
from irsim_gym.evaluation.measures.metrics import EpisodeRow
from irsim_gym.evaluation.measures.team_metrics import AgentRow, TeamRow
from irsim_gym.evaluation.protocol.tables import write_json
from irsim_gym.evaluation.saved_policies.algorithms import find_algorithm
from irsim_gym.evaluation.saved_policies.checkpoint_files import PROGRESS, load_progress
from irsim_gym.evaluation.saved_policies.shelf import shelf_file
from irsim_gym.evaluation.suite.members import read_suite
from irsim_gym.evaluation.suite.row_files import read_rows, write_rows
from irsim_gym.evaluation.suite.suite_record import read_record
from irsim_gym.rendering.looks import images
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs.library import configs_folder
from irsim_gym.tasks import load_task
from irsim_gym.training.curves.score import read_curve
from irsim_gym.training.export.results_files import read_results
from irsim_gym.training.searches.search_space import read_space
from irsim_gym.training.settings.hyperparameter_files import read_hyperparameters
from irsim_gym.training.settings.mixture import read_mixture
from irsim_gym.training.settings.run import Run

Breaker = Callable[[bytes, Random], bytes]
AGENTS = Path(__file__).parents[2] / "agents"


@dataclasses.dataclass(frozen=True)
class Kind:
    """A kind of files.

    Attributes:
        name: Name of the file.
        make: Writes a valid one.
        read: Reads it.
        breakers: Ways to damage it, besides its bytes.
    """

    name: str
    make: Callable[[Path], object]
    read: Callable[[Path], object]
    breakers: tuple[Breaker, ...] = ()


def copy_of(source: Path) -> Callable[[Path], object]:
    return lambda file: file.write_bytes(source.read_bytes())


def text_of(text: str) -> Callable[[Path], object]:
    return lambda file: file.write_text(text, encoding="utf-8")


def levels(file: Path) -> None:
    start = np.tile([[1.0, 1.0, 0.0], [5.0, 5.0, 0.0]], (4, 1, 1))
    goal = np.full((4, 2, 3), np.nan)
    goal[:, 0] = [8.0, 8.0, 0.0]
    discs, offsets = np.array([[0.0, 0.0, 0.5]]), np.tile([0, 0, 1], (4, 1))
    about = np.array(json.dumps({"source": "made up"}))
    splits = {"splits": np.array(["train", "test"]), "split_start": np.array([0, 2, 4])}
    named = np.array(["robot_0", "obstacle_1"])
    np.savez(file, bodies=named, start=start, goal=goal, discs=discs, disc_start=offsets, about=about, **splits)


def load_levels(file: Path) -> object:
    robot = "{kinematics: {name: diff}, distribution: {name: random}}"
    return load_with(f"robot: {robot}\nobstacle: {{shape: {{name: circle}}}}\nlevels: {file.name}\n")(file)


def demonstrations(file: Path) -> None:
    rng, ends = np.random.default_rng(0), np.array([0, 0, 1, 0, 1], bool)
    box = {"kind": "Box", "shape": [3], "dtype": "float32", "low": -1.0, "high": 1.0}
    about = {"format": 1, "observation_space": box, "action_space": {**box, "shape": [2]}}
    seen = rng.random((5, 3), np.float32)
    flags = ends, np.zeros(5, bool), np.roll(ends, 1), np.zeros(5, bool)
    outcomes = np.array([0, 1]), np.array([1, 2])
    save_demonstrations(
        file, Demonstrations(seen, rng.random((5, 2), np.float32), np.ones(5), *flags, seen[:2], *outcomes, about)
    )


EPISODES = [EpisodeRow(k, "success", "", 50, 5.0, 6.0, 4.5, 0.25) for k in range(4)]
TEAMS = [
    TeamRow(
        k, 30.0, tuple(AgentRow(f"robot_{a}", dataclasses.replace(EPISODES[k], level=k), 4.0, 1.0, False) for a in "01")
    )
    for k in range(4)
]


def suite_record(file: Path) -> None:
    conditions = {"levels": 4, "split": "test", "agents": ["robot_0"], "level_hash": "0", "level_file": None}
    member = {
        "scenario": "maze",
        "parameters": {},
        "team": False,
        "differs": "",
        "sha256": "0",
        "conditions": conditions,
    }
    runs = {"maze": {"dash": [{"file": "rows/maze/dash-0.csv", "seconds": 1.0}]}}
    data = {"split": "test", "levels": 4, "members": {"maze": member}, "methods": {"dash": [{"source": "dash"}]}}
    write_json(file, {**data, "runs": runs, "figures": {}, "overall": {}, "machine": {}})


def run_config(file: Path) -> None:
    hyper = {"n_timesteps": 100, "n_envs": 2, "learning_rate": 0.001, "policy_kwargs": {"net_arch": [8]}}
    settings = {"scenario": "maze", "algorithm": "ppo", "seed": 0, "parameters": {"loops": 0.4}, "task": None}
    mixture = [{"scenario": "maze", "parameters": {}, "share": 1.0}]
    whole = {**settings, "hyperparameters": hyper, "mixture": mixture}
    write_json(file, {"settings": whole, "copy": {"file": "maze.yaml", "sha256": "0"}, "machine": {}})


def read_run(file: Path) -> object:
    run = Run(file.parent)
    return run.settings().to_plain(), run.snapshot()


def figures(file: Path) -> None:
    share = {"count": 3, "value": 0.75, "low": 0.3, "high": 0.95}
    row = {"policy": "seed_1", "success": share, "collision": share, "timeout": share, "spl": 0.7}
    conditions = {"split": "test", "levels": 4, "level_hash": "0", "parameters": {}, "scenario": "maze"}
    write_json(file, {"conditions": conditions, "policies": [row, {**row, "policy": "dash"}]})


def load_zip(file: Path) -> object:
    from irsim_gym.evaluation.saved_policies.saved_models import load_model

    return load_model(file)


def load_pickled_state(file: Path) -> object:
    from irsim_gym.training.runs.checkpoint import load_state

    return load_state(file.parent)


def load_with(text: str) -> Callable[[Path], object]:
    """Return the function that loads a scenario beside a file, which uses it."""

    def load(file: Path) -> object:
        scenario = file.with_name(f"{file.name}.yaml")
        scenario.write_text(text)
        return load_scenario(scenario)

    return load


def read_image(file: Path) -> object:
    images._read.cache_clear()
    return images.load_image(file)


def load_own_task(file: Path) -> object:
    return load_task(load_scenario("maze", warn=False), file)


def shipped(place: str) -> Callable[[Path], object]:
    return copy_of(configs_folder() / place)


PACKED = (broken_archive, broken_archive, broken_archive)
DATA = (broken_json, broken_json)
TEXT = (broken_text, broken_text, broken_text)

KINDS = {
    "levels": Kind("levels.npz", levels, load_levels, PACKED),
    "certificate": Kind("c.npz", shipped("certificates/parking.npz"), read_certificate, PACKED),
    "shelf policy": Kind("p.npz", copy_of(shelf_file("cluttered_room")), irsim_gym.load_policy, PACKED),
    "demonstrations": Kind("d.npz", demonstrations, irsim_gym.load_demonstrations, PACKED),
    "policy.zip": Kind("policy.zip", copy_of(AGENTS / "policies/circle_swap_seed_0.zip"), load_zip, PACKED),
    "state.pkl": Kind(
        "state.pkl", lambda file: file.write_bytes(pickle.dumps({"a": np.arange(9)})), load_pickled_state
    ),
    "rows of the suite": Kind("s.csv", lambda file: write_rows(file, TEAMS), lambda file: read_rows(file, 4), TEXT),
    "suite record": Kind("summary.json", suite_record, lambda file: read_record(file.parent), DATA),
    "settings of a run": Kind("config.json", run_config, read_run, DATA),
    "progress": Kind(
        PROGRESS, text_of('{"steps": 3, "history": [{"steps": 1}]}'), lambda file: load_progress(file.parent), DATA
    ),
    "curve": Kind("curve.json", text_of('{"points": [{"steps": 3}]}'), lambda file: read_curve(Run(file.parent)), DATA),
    "figures of policies": Kind("f.json", figures, lambda file: read_results(file, Path("runs/x_seed_1")), DATA),
    "card": Kind(
        "p.json",
        copy_of(shelf_file("cluttered_room").with_suffix(".json")),
        lambda file: irsim_gym.evaluation.saved_policies.cards.read_card(file.with_suffix(".npz")),
        DATA,
    ),
    "scenario": Kind("s.yaml", shipped("scenarios/cluttered_room.yaml"), load_scenario, TEXT),
    "scenario of a map": Kind("m.yaml", shipped("benchmarks/maze.yaml"), load_scenario, TEXT),
    "map image": Kind(
        "map.png", shipped("maps/cavern.png"), load_with("world: {obstacle_map: {name: image, path: map.png}}")
    ),
    "recording": Kind(
        "r.txt",
        shipped("recordings/square.txt"),
        load_with(
            "obstacle: {kinematics: {name: omni}, vel_min: [-2, -2], vel_max: [2, 2], "
            "behavior: {name: recorded, file: r.txt}}"
        ),
        TEXT,
    ),
    "image of a body": Kind("b.png", shipped("images/car_red.png"), read_image),
    "task": Kind("t.yaml", shipped("tasks/navigation.yaml"), load_own_task, TEXT),
    "suite": Kind("suite.yaml", shipped("suite.yaml"), read_suite, TEXT),
    "mixture": Kind(
        "x.yaml",
        text_of("mixture:\n  - maze\n  - {scenario: rooms, share: 2}\ntask: general_navigation\n"),
        read_mixture,
        TEXT,
    ),
    "hyper-parameters": Kind(
        "h.yaml",
        copy_of(AGENTS / "hyperparameters/ppo.yaml"),
        lambda file: read_hyperparameters(file, find_algorithm("ppo"), "irsim_gym/maze-v0", None, {}),
        TEXT,
    ),
    "search space": Kind("space.yaml", copy_of(AGENTS / "hyperparameters/spaces/ppo.yaml"), read_space, TEXT),
}


def damaged(kind: Kind, content: bytes, random: Random) -> bytes:
    """Return the content of a file of a kind, damaged in one way."""
    breakers = (broken_bytes, broken_bytes, *kind.breakers)
    return breakers[int(random.integers(len(breakers)))](content, random)
