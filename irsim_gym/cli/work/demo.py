"""The command ``irsim-gym demo``: train a policy, score it, evaluate it, and film it."""

from pathlib import Path

from rich.console import Console

from irsim_gym.base.errors import UnreadableFileError
from irsim_gym.base.outside_files import json_object, reading
from irsim_gym.evaluation.comparison.evaluate import evaluate_policies
from irsim_gym.evaluation.comparison.record import record_film
from irsim_gym.evaluation.protocol.tables import write_bytes
from irsim_gym.evaluation.requests.interruption import TrainingInterruptedError, ctrl_c_as_error
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.checkpoint_files import NORMALIZATION
from irsim_gym.training.curves.score import reached, score_run
from irsim_gym.training.requests.train import train
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.settings.run import Run

FILMED = (0, 1, 2, 3)
"""Levels of the film."""
FILES = {
    "film": "film.mp4",
    "curve": "curve.png",
    "table": "table.txt",
    "policy": "policy.zip",
    "episodes": "episodes.csv",
    "summary": "summary.json",
}


def run_demo(
    folder: Path, *, scenario: str = "cluttered_room", steps: int | None = None, levels: int = 1000, seed: int = 0
) -> None:
    """Train, score, evaluate and film a policy. Stages that are already done are skipped.

    Args:
        folder: Folder of all results; the training run is in ``folder / "run"``.
        scenario: Shipped name, environment id, or path of a scenario file.
        steps: Number of training steps; None for that of the hyper-parameter file.
        levels: Number of ``test`` levels of the evaluation, and of ``dev`` levels of the learning curve.

    Raises:
        TrainingInterruptedError: If Ctrl-C or, during training, SIGTERM stops it. The next call resumes.
    """
    with ctrl_c_as_error("stopped. Run the same command to continue."):
        _stages(folder, scenario, steps, levels, seed)


def _stages(folder: Path, scenario: str, steps: int | None, levels: int, seed: int) -> None:
    screen, run, asked = Console(stderr=True), Run(folder / "run"), ScenarioRequest(scenario)
    request = TrainingRequest(scenario, "ppo", seed, steps)
    settings = request.settings()
    if run.exists():
        settings = request.resumed_settings(run, settings)
    _say(screen, 1, f"training PPO on {scenario}, {settings.hyperparameters.n_timesteps:,} steps", run.finished())
    try:
        train(settings, run.folder, resume=True, console=screen)
    except TrainingInterruptedError as stop:
        raise TrainingInterruptedError(f"{stop}. Run the same command to continue.", stop.signal) from None
    _copy(run, folder)
    _say(screen, 2, f"scoring the checkpoints on {levels:,} dev levels", False)
    points = score_run(run, levels=levels, console=screen)
    write_bytes(folder / FILES["curve"], (run.folder / "curve.png").read_bytes())
    done = _evaluated(folder, levels)
    _say(screen, 3, f"evaluating on {levels:,} test levels, beside random and dash", done)
    policy, film = folder / FILES["policy"], folder / FILES["film"]
    if not done:
        evaluate_policies(asked, {"ppo": policy}, levels=levels, folder=folder)
    filmed = film.is_file() and film.stat().st_mtime >= policy.stat().st_mtime
    _say(screen, 4, "filming it beside dash", filmed)
    if not filmed:
        record_film(asked, [policy, "dash"], FILMED, film, names=["ppo", "dash"])
    print((folder / FILES["table"]).read_text(encoding="utf-8"))
    held = reached(points, 0.95)
    if held is not None:
        print(f"95 % success after {held['training_seconds']:.1f} s of training ({held['steps']:,.0f} steps)")
    for name, file in FILES.items():
        print(f"{name:<9} {folder / file}")


def _copy(run: Run, folder: Path) -> None:
    """Copy the policy into the folder of the demonstration. An identical file keeps its modification time."""
    for name in (NORMALIZATION, run.policy.name):
        source, target = run.folder / name, folder / name
        if source.is_file() and not (target.is_file() and target.read_bytes() == source.read_bytes()):
            write_bytes(target, source.read_bytes())


def _evaluated(folder: Path, levels: int) -> bool:
    """Return whether there is a table for this number of levels that is not older than the policy."""
    table = folder / FILES["table"]
    try:
        with reading(folder / FILES["summary"], "summary of an evaluation"):
            found = json_object(folder / FILES["summary"])
            fresh = table.stat().st_mtime >= (folder / FILES["policy"]).stat().st_mtime
            return fresh and bool(found["conditions"]["levels"] == levels)
    except UnreadableFileError:
        return False


def _say(screen: Console, number: int, what: str, done: bool) -> None:
    screen.print(f"[{number}/4] {what}{' (done before)' if done else ''}", markup=False, highlight=False)
