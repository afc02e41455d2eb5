"""The command ``irsim-gym arena``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from irsim_gym.cli_completion import policies as policies_that_begin
from irsim_gym.cli_options import Given, Imports, Lenient, Levels, Scenario, Split, Task, Team
from irsim_gym.cli_tools import read_parameters


def arena(
    scenario: Scenario,
    policies: Annotated[
        list[str] | None,
        typer.Argument(
            help="Folders of runs, policy.zip files, random, behaviors such as dash, rvo, sfm, orca.",
            autocompletion=policies_that_begin,
        ),
    ] = None,
    levels: Levels = 1000,
    split: Split = "test",
    task: Task = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results (default: runs/arena-SCENARIO[-team]-SPLIT, numbered).")
    ] = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="Continue the arena in the folder: finished policies do not play again, further ones may join.",
        ),
    ] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the arena in the folder.")] = False,
    replays: Annotated[int, typer.Option(min=0, help="Maximum number of episodes that the page can play.")] = 200,
    team: Team = False,
    given: Given = None,
    lenient: Lenient = False,
    modules: Imports = None,
) -> None:
    """Play the same levels with several policies, and write a page of the results, with replays of failures."""
    from irsim_gym.arenas.command import run_arena
    from irsim_gym.training.scenario_request import ScenarioRequest

    asked = ScenarioRequest(scenario, task, team, read_parameters(given), not lenient)
    chosen: dict[str, Any] = {"levels": levels, "split": split, "replays": replays}
    run_arena(asked, policies or [], out, resume=resume, overwrite=overwrite, **chosen)
