"""The commands ``irsim-gym levels``: levels as files. Everything heavy is imported by the command that needs it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from irsim_gym.cli_options import MOST_LEVELS, Given, Imports, Lenient, Scenario, Task, Team
from irsim_gym.cli_tools import read_parameters

levels = typer.Typer(
    help="Levels as files: draw them, import those of others, certify and show them.",
    no_args_is_help=True,
    add_completion=False,
)

Splits = Annotated[str, typer.Option("--split", help="Split of the levels: train, dev or test; several: train,dev.")]
Count = Annotated[int, typer.Option(min=1, max=MOST_LEVELS, help="Number of levels of each split.")]
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
