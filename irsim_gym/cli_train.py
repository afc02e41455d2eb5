"""The command ``irsim-gym train``."""

from __future__ import annotations

from typing import Any

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
    )
    how: dict[str, Any] = {"resume": resume, "overwrite": overwrite, "dev_levels": dev_levels}
    if seeds is None:
        run_training(asked, out, **how)
        return
    from irsim_gym.training.seed_runs import run_seeds

    run_seeds(asked, seeds, out, test_levels=test_levels, **how)
