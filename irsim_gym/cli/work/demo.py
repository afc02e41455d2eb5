"""The command ``irsim-gym demo``: train a policy, score it, evaluate it, and film it."""

from pathlib import Path

from irsim_gym.cli.work.commands import run_evaluation, run_record, run_training
from irsim_gym.evaluation.requests.interruption import TrainingInterruptedError, ctrl_c_as_error
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.settings.run import Run

FILMED = (0, 1, 2, 3)
"""Levels of the film."""
TO_GO_ON = "stopped. Run the same command to continue."


def run_demo(
    folder: Path, *, scenario: str = "cluttered_room", steps: int | None = None, levels: int = 1000, seed: int = 0
) -> None:
    """Train and score a policy, evaluate it beside random and dash, and film it beside dash.

    Args:
        folder: Folder of the results: the training in ``run``, the evaluation in ``test``, and ``film.mp4``.
        scenario: Shipped name, environment id, or path of a scenario file.
        steps: Number of training steps; None for that of the hyper-parameter file.
        levels: Number of ``test`` levels of the evaluation, and of ``dev`` levels of the learning curve.

    Raises:
        TrainingInterruptedError: If Ctrl-C or, during training, SIGTERM stops it. The next call resumes the training.
    """
    run, film, wish = Run(folder / "run"), folder / "film.mp4", ScenarioRequest(scenario)
    try:
        with ctrl_c_as_error(TO_GO_ON):
            request = TrainingRequest(scenario, "ppo", seed, steps)
            run_training(request, run.folder, resume=run.exists(), dev_levels=levels)
            evaluated = [f"ppo={run.folder}"]
            run_evaluation(wish, evaluated, levels=levels, split="test", out=folder / "test", overwrite=True)
            run_record(wish, [str(run.folder), "dash"], FILMED, "test", film, "film", overwrite=True)
    except TrainingInterruptedError as stop:
        raise TrainingInterruptedError(TO_GO_ON, stop.signal) from None
