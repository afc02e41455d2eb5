"""The commands ``irsim-gym levels``: levels as files. Each command imports the heavy packages that it needs."""

from pathlib import Path
from typing import Annotated

import typer

from irsim_gym.cli import options as opt
from irsim_gym.cli.tools import scenario_request

levels = typer.Typer(help="Levels as files: draw and certify them.", no_args_is_help=True, add_completion=False)

Splits = Annotated[str, typer.Option("--split", help="Split of the levels: train, dev or test; several: train,dev.")]
Count = Annotated[int, typer.Option(min=1, max=opt.MOST_LEVELS, help="Number of levels of each split.")]
Policies = Annotated[list[str] | None, typer.Argument(help="Reference policies (default: those that fit).")]
Certified = Annotated[str, typer.Argument(help="Shipped name, environment id, YAML file, or file of levels (.npz).")]
OutOrBeside = Annotated[Path | None, typer.Option(help="File to write (default: NAME.certificate.npz beside it).")]
Out = Annotated[Path, typer.Option(help="File to write, .npz.")]


@levels.command()
def draw(
    scenario: opt.Scenario,
    out: Out,
    split: Splits = "test",
    count: Count = 1000,
    task: opt.Task = None,
    team: opt.Team = False,
    settings: opt.Given = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Write levels to a file. Scenarios read it with `levels: FILE.npz`; NumPy can open it, too."""
    from irsim_gym.evaluation.levels.level_commands import run_draw

    run_draw(scenario_request(scenario, task, team, settings, lenient), split.split(","), count, out)


@levels.command()
def certify(
    scenario: Certified,
    policies: Policies = None,
    out: OutOrBeside = None,
    split: opt.Split = "test",
    count: Count = 1000,
    task: opt.Task = None,
    team: opt.Team = False,
    settings: opt.Given = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Measure levels, play them with reference policies, and write a certificate (docs/levels.md).

    `evaluate` finds the certificate beside the scenario, or beside its file of levels, and reports by difficulty.
    """
    from irsim_gym.evaluation.levels.level_commands import run_certify

    request = scenario_request(scenario, task, team, settings, lenient)
    run_certify(request, split, count, policies or None, out)
