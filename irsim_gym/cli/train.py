"""The commands ``irsim-gym train`` and ``irsim-gym tune``."""

from pathlib import Path
from typing import Annotated, Any

import typer

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.extras import require
from irsim_gym.cli import options as opt
from irsim_gym.cli.tools import read_changes, read_parameters


def train(
    scenario: opt.Scenarios,
    algorithm: opt.Algorithm = None,
    seed: opt.Seed = 0,
    steps: opt.Steps = None,
    task: opt.Task = None,
    out: opt.RunFolder = None,
    hyperparameters: opt.Hyperparameters = None,
    changes: opt.Changes = None,
    resume: opt.Resume = False,
    more_steps: opt.MoreSteps = None,
    until: opt.Until = None,
    overwrite: opt.BeginAnew = False,
    origin: opt.Origin = None,
    device: opt.Device = None,
    dev_levels: opt.DevLevels = 1000,
    team: opt.TeamMode = None,
    seeds: opt.Seeds = None,
    test_levels: opt.TestLevels = 1000,
    mixture: opt.Mixture = False,
    settings: opt.Given = None,
    perturb: opt.Perturbed = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Train a policy, then score its checkpoints. Ctrl-C writes a checkpoint for --resume."""
    from irsim_gym.cli.work.commands import run_training
    from irsim_gym.cli.work.seed_runs import run_seeds
    from irsim_gym.training.requests.training_request import TrainingRequest
    from irsim_gym.training.settings.mixture import requested_mixture

    if more_steps is not None and seeds is not None:
        raise IrsimGymError("--more-steps is for one run: name its folder with --out, and leave out --seeds")
    if resume and out is not None and not any((*out.glob("config.json"), *out.glob("seed_*/config.json"))):
        raise IrsimGymError(f"--resume: {out} holds no run; without --resume the same command begins one there")
    mixed = requested_mixture(scenario, mixture)
    request = TrainingRequest(
        *(scenario[0], algorithm, seed, steps, task, hyperparameters, team, read_parameters(settings, perturb)),
        *(not lenient, device, origin),
        changes=read_changes(changes),
        until=until,
    )
    request = request if mixed is None else request.with_mixture(mixed)
    how: dict[str, Any] = {"resume": resume, "overwrite": overwrite, "dev_levels": dev_levels}
    if seeds is None:
        run_training(request, out, more_steps=more_steps, **how)
    else:
        run_seeds(request, seeds, out, test_levels=test_levels, **how)


def tune(
    scenario: Annotated[
        list[str], typer.Argument(metavar="SCENARIO...", help=opt.HELP["tune scenario"], show_default=False)
    ],
    trials: Annotated[int | None, typer.Option(min=1, help=opt.HELP["tune trials"])] = None,
    space: Annotated[Path | None, typer.Option(help=opt.HELP["tune space"])] = None,
    grid: Annotated[bool, typer.Option("--grid", help=opt.HELP["tune grid"])] = False,
    algorithm: opt.Algorithm = None,
    seed: opt.Seed = 0,
    steps: opt.Steps = None,
    task: opt.Task = None,
    out: Annotated[Path | None, typer.Option(help=opt.HELP["tune out"])] = None,
    hyperparameters: opt.Hyperparameters = None,
    changes: opt.Changes = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help=opt.HELP["tune overwrite"])] = False,
    device: opt.Device = None,
    dev_levels: Annotated[int, typer.Option(min=1, help=opt.HELP["tune dev_levels"])] = 300,
    team: opt.TeamMode = None,
    settings: opt.Given = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
    workers: Annotated[int, typer.Option(min=1, max=10_000, help=opt.HELP["tune workers"])] = 1,
) -> None:
    """Search with Optuna, or through a grid, for hyper-parameters, weights of rewards, parameters, seeds, scenarios.

    Each trial is a training run. The same command continues an interrupted study. In a search, trials whose success on
    dev levels stays below the median are pruned.
    """
    require("tune", "irsim-gym tune")
    from irsim_gym.training.requests.training_request import TrainingRequest
    from irsim_gym.training.searches.tuning import run_tuning

    parameters = read_parameters(settings)
    request = TrainingRequest(
        *(scenario[0], algorithm, seed, steps, task, hyperparameters, team, parameters, not lenient, device),
        changes=read_changes(changes),
    )
    how: dict[str, Any] = {"dev_levels": dev_levels, "modules": tuple(modules or ())}
    how |= {"workers": workers, "overwrite": overwrite, "grid": grid}
    run_tuning(request, trials, scenarios=scenario, space=space, out=out, **how)
