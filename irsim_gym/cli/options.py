"""Arguments and options of the command line, each declared once."""

from pathlib import Path
from typing import Annotated

import typer

from irsim_gym.base.imports import import_modules
from irsim_gym.base.outside_files import json_object
from irsim_gym.cli.tools import read_count

HELP = json_object(Path(__file__).with_name("help.json"))
"""Help of each option, by its name here; of those that one command has, by the function and its argument."""
LAST_SEED = 2**32 - 1  # largest seed of NumPy's legacy generator, which Stable-Baselines3 seeds
LAST_LEVEL = 2**53 - 1  # largest level of an environment
MOST_LEVELS = 10**9

Scenario = Annotated[str, typer.Argument(help=HELP["Scenario"])]
Scenarios = Annotated[list[str], typer.Argument(metavar="SCENARIO", help=HELP["Scenarios"])]
Mixture = Annotated[bool, typer.Option("--mixture", help=HELP["Mixture"])]
Task = Annotated[str | None, typer.Option(help=HELP["Task"])]
Levels = Annotated[int, typer.Option(min=1, max=MOST_LEVELS, help=HELP["Levels"])]
Split = Annotated[str, typer.Option(help=HELP["Split"])]
Steps = Annotated[int | None, typer.Option(parser=read_count, metavar="STEPS", help=HELP["Steps"])]
MoreSteps = Annotated[int | None, typer.Option(parser=read_count, metavar="STEPS", help=HELP["MoreSteps"])]
Until = Annotated[float | None, typer.Option(max=100.0, help=HELP["Until"])]
Changes = Annotated[list[str] | None, typer.Option("--hp", metavar="KEY=VALUE", help=HELP["Changes"])]
Seed = Annotated[int, typer.Option(min=0, max=LAST_SEED, help=HELP["Seed"])]
Seeds = Annotated[int | None, typer.Option(min=1, help=HELP["Seeds"])]
TestLevels = Annotated[int, typer.Option(min=1, help=HELP["TestLevels"])]
Watched = Annotated[str | None, typer.Argument(help=HELP["Watched"])]
Given = Annotated[list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help=HELP["Given"])]
Perturbed = Annotated[list[str] | None, typer.Option("--perturb", metavar="NAME:KEY=VALUE", help=HELP["Perturbed"])]
Shield = Annotated[str | None, typer.Option("--shield", metavar="NAME:KEY=VALUE", help=HELP["Shield"])]
Team = Annotated[bool, typer.Option("--team", help=HELP["Team"])]
Lenient = Annotated[bool, typer.Option("--lenient", help=HELP["Lenient"])]
Imports = Annotated[
    list[str] | None,
    typer.Option("--import", callback=import_modules, is_eager=True, metavar="MODULE|FILE.py", help=HELP["Imports"]),
]

Algorithm = Annotated[str | None, typer.Option(callback=lambda name: name and name.lower(), help=HELP["Algorithm"])]
RunFolder = Annotated[Path | None, typer.Option(help=HELP["RunFolder"])]
Hyperparameters = Annotated[Path | None, typer.Option(help=HELP["Hyperparameters"])]
Resume = Annotated[bool, typer.Option("--resume", help=HELP["Resume"])]
ReplaceFile = Annotated[bool, typer.Option("--overwrite", help=HELP["ReplaceFile"])]
BeginAnew = Annotated[bool, typer.Option("--overwrite", help=HELP["BeginAnew"])]
Origin = Annotated[str | None, typer.Option("--from", metavar="RUN", help=HELP["Origin"])]
Device = Annotated[str | None, typer.Option(help=HELP["Device"])]
DevLevels = Annotated[int, typer.Option(min=0, help=HELP["DevLevels"])]
TeamMode = Annotated[str | None, typer.Option(help=HELP["TeamMode"])]
