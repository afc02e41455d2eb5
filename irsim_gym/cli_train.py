"""The commands ``irsim-gym train`` and ``irsim-gym tune``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from irsim_gym.cli_options import (
    Algorithm,
    BeginAnew,
    Curriculum,
    Device,
    DevLevels,
    Given,
    Hyperparameters,
    Imports,
    Lenient,
    Log,
    Origin,
    Resume,
    RunFolder,
    Scenario,
    Seed,
    Seeds,
    Steps,
    Task,
    TeamMode,
    TestLevels,
)
from irsim_gym.cli_tools import read_parameters


def train(
    scenario: Scenario,
    algorithm: Algorithm = None,
    seed: Seed = 0,
    steps: Steps = None,
    task: Task = None,
    out: RunFolder = None,
    hyperparameters: Hyperparameters = None,
    resume: Resume = False,
    overwrite: BeginAnew = False,
    origin: Origin = None,
    device: Device = None,
    dev_levels: DevLevels = 1000,
    team: TeamMode = None,
    curriculum: Curriculum = None,
    seeds: Seeds = None,
    test_levels: TestLevels = 1000,
    given: Given = None,
    lenient: Lenient = False,
    modules: Imports = None,
    log: Log = None,
) -> None:
    """Train an agent, then score its checkpoints. Ctrl-C writes a checkpoint for --resume."""
    from irsim_gym.training.asked import Asked
    from irsim_gym.training.commands import run_training

    asked = Asked(
        scenario,
        algorithm,
        seed,
        steps,
        task,
        hyperparameters,
        team,
        read_parameters(given),
        not lenient,
        device,
        origin,
        curriculum,
        log=tuple(log or ()),
    )
    how: dict[str, Any] = {"resume": resume, "overwrite": overwrite, "dev_levels": dev_levels}
    if seeds is None:
        run_training(asked, out, **how)
        return
    from irsim_gym.training.seed_runs import run_seeds

    run_seeds(asked, seeds, out, test_levels=test_levels, **how)


def tune(
    scenario: Scenario,
    trials: Annotated[
        int, typer.Option(min=1, help="Number of trials, those that the folder holds already included.")
    ] = 40,
    space: Annotated[
        Path | None, typer.Option(help="YAML file of what may change (default: the algorithm's shipped one).")
    ] = None,
    algorithm: Algorithm = None,
    seed: Seed = 0,
    steps: Steps = None,
    task: Task = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the study (default: runs/tune-, then as the folder of a run).")
    ] = None,
    hyperparameters: Hyperparameters = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the study in the folder.")] = False,
    device: Device = None,
    dev_levels: Annotated[int, typer.Option(min=1, help="Number of dev levels to score each checkpoint on.")] = 300,
    team: TeamMode = None,
    curriculum: Curriculum = None,
    given: Given = None,
    lenient: Lenient = False,
    modules: Imports = None,
) -> None:
    """Search for hyper-parameters and weights of rewards with Optuna. The same command goes on where it was stopped.

    Each trial is a training run with one seed. Trials whose success on dev levels stays below the median are pruned.
    """
    from irsim_gym.training.asked import Asked
    from irsim_gym.training.tuning import run_tuning

    parameters = read_parameters(given)
    asked = Asked(
        scenario, algorithm, seed, steps, task, hyperparameters, team, parameters, not lenient, device, None, curriculum
    )
    run_tuning(asked, trials, space=space, out=out, overwrite=overwrite, dev_levels=dev_levels)
