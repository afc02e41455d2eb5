"""The commands ``irsim-gym train`` and ``irsim-gym tune``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from irsim_gym.cli_options import (
    Address,
    Algorithm,
    BeginAnew,
    Curriculum,
    Device,
    DevLevels,
    EngineName,
    Given,
    Hyperparameters,
    Imports,
    LearnerGpus,
    Lenient,
    Log,
    Mixture,
    Origin,
    Resume,
    RunFolder,
    Scenario,
    Scenarios,
    Seed,
    Seeds,
    Steps,
    Task,
    TeamMode,
    TestLevels,
    Workers,
    WorldsPerWorker,
)
from irsim_gym.cli_tools import read_parameters
from irsim_gym.errors import IrsimGymError
from irsim_gym.extras import require


def train(
    scenario: Scenarios,
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
    mixture: Mixture = False,
    given: Given = None,
    lenient: Lenient = False,
    modules: Imports = None,
    engine: EngineName = None,
    workers: Workers = None,
    worlds_per_worker: WorldsPerWorker = None,
    learner_gpus: LearnerGpus = None,
    address: Address = None,
    log: Log = None,
) -> None:
    """Train an agent, then score its checkpoints. Ctrl-C writes a checkpoint for --resume."""
    from irsim_gym.training.asked import Asked
    from irsim_gym.training.commands import run_training
    from irsim_gym.training.engines import engine_of

    asked = Asked(
        _first_scenario(scenario, mixture),
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
        tuple(scenario) if mixture else (),
        engine_of(engine, workers, worlds_per_worker, learner_gpus, address),
        log=tuple(log or ()),
    )
    how: dict[str, Any] = {"resume": resume, "overwrite": overwrite, "dev_levels": dev_levels, "address": address}
    if seeds is None:
        run_training(asked, out, **how)
        return
    from irsim_gym.training.seed_runs import run_seeds

    run_seeds(asked, seeds, out, test_levels=test_levels, **how)


def _first_scenario(scenarios: Sequence[str], mixture: bool) -> str:
    """Return the name of the first scenario, after a check that as many are wanted as are given."""
    from irsim_gym.training.mixture import read_part

    if not mixture:
        if len(scenarios) > 1:
            given = ", ".join(scenarios)
            raise IrsimGymError(f"train takes one scenario, got {given}: --mixture trains one policy in all")
        return scenarios[0]
    return read_part(scenarios[0]).scenario


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
    require("tune", "irsim-gym tune")
    from irsim_gym.training.asked import Asked
    from irsim_gym.training.tuning import run_tuning

    parameters = read_parameters(given)
    asked = Asked(
        scenario, algorithm, seed, steps, task, hyperparameters, team, parameters, not lenient, device, None, curriculum
    )
    run_tuning(asked, trials, space=space, out=out, overwrite=overwrite, dev_levels=dev_levels)


def sweep(
    file: Annotated[Path, typer.Argument(metavar="SWEEP.yaml", help="What is trained, see docs/rllib.md.")],
    out: Annotated[Path | None, typer.Option(help="Folder of the sweep (default: runs/sweep-NAME).")] = None,
    workers: Annotated[int, typer.Option(min=1, max=10_000, help="Trainings at a time on this machine.")] = 1,
    address: Address = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the sweep in the folder.")] = False,
    modules: Imports = None,
) -> None:
    """Train every combination of seeds, hyper-parameters, rewards, scenarios and parameters in a file, by Ray Tune.

    The same command goes on where it was stopped. One table at the end sums the seeds up.
    """
    require("rllib", "irsim-gym sweep")
    from irsim_gym.training.ray_session import prepare

    prepare(address)
    from irsim_gym.training.sweep import run_sweep

    run_sweep(file, out=out, workers=workers, address=address, overwrite=overwrite, modules=modules or ())
