"""The commands ``irsim-gym levels``: levels as files. Everything heavy is imported by the command that needs it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from irsim_gym.cli_options import MOST_LEVELS, Given, Imports, Lenient, Scenario, Split, Task, Team
from irsim_gym.cli_tools import read_parameters

levels = typer.Typer(
    help="Levels as files: draw them, import those of others, certify and show them.",
    no_args_is_help=True,
    add_completion=False,
)

Splits = Annotated[str, typer.Option("--split", help="Split of the levels: train, dev or test; several: train,dev.")]
Count = Annotated[int, typer.Option(min=1, max=MOST_LEVELS, help="Number of levels of each split.")]
Policies = Annotated[
    str | None,
    typer.Option(help="Reference policies, separated by commas (default: random, dash, orca, dwa, pursuit); none: ''."),
]
Certified = Annotated[str, typer.Argument(help="Shipped name, environment id, YAML file, or file of levels (.npz).")]
OutOrBeside = Annotated[
    Path | None, typer.Option(help="File to write, .npz (default: beside the file, NAME.certificate.npz).")
]
Out = Annotated[Path, typer.Option(help="File to write, .npz.")]


@levels.command()
def draw(
    scenario: Scenario,
    out: Out,
    split: Splits = "test",
    count: Count = 1000,
    task: Task = None,
    team: Team = False,
    given: Given = None,
    lenient: Lenient = False,
    modules: Imports = None,
) -> None:
    """Write levels into a file, which a scenario reads with `levels: FILE.npz` and everybody with NumPy."""
    from irsim_gym.training.level_commands import Wanted, run_draw

    run_draw(Wanted(scenario, task, team, read_parameters(given), not lenient), split.split(","), count, out)


@levels.command()
def certify(
    scenario: Certified,
    out: OutOrBeside = None,
    split: Split = "test",
    count: Count = 1000,
    policies: Policies = None,
    task: Task = None,
    team: Team = False,
    given: Given = None,
    lenient: Lenient = False,
    modules: Imports = None,
) -> None:
    """Measure levels, let reference policies drive them, and write what is found (docs/levels.md).

    `evaluate` finds the certificate beside the scenario, or beside its file of levels, and reports by difficulty.
    """
    from irsim_gym.training.level_commands import Wanted, run_certify

    wanted = Wanted(scenario, task, team, read_parameters(given), not lenient)
    chosen = None if policies is None else [name.strip() for name in policies.split(",") if name.strip()]
    run_certify(wanted, split, count, chosen, out)
