"""The commands ``irsim-gym arena`` and ``irsim-gym robustness``."""

from pathlib import Path
from typing import Annotated, Any

import typer

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.cli import options as opt
from irsim_gym.cli.tools import scenario_request


def arena(
    scenario: opt.Scenario,
    policies: Annotated[list[str] | None, typer.Argument(help=opt.HELP["arena policies"])] = None,
    levels: opt.Levels = 1000,
    split: opt.Split = "test",
    task: opt.Task = None,
    out: Annotated[Path | None, typer.Option(help=opt.HELP["arena out"])] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help=opt.HELP["arena overwrite"])] = False,
    replays: Annotated[int, typer.Option(min=0, help=opt.HELP["arena replays"])] = 200,
    team: opt.Team = False,
    settings: opt.Given = None,
    perturb: opt.Perturbed = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Play the same levels with several policies, and write a page of the results, with replays of failures."""
    from irsim_gym.cli.work.commands import print_evaluation, requested_evaluation
    from irsim_gym.evaluation.arena.contest import arena as play
    from irsim_gym.evaluation.saved_policies.policy_places import cure_of

    request = scenario_request(scenario, task, team, settings, lenient, perturb)
    if not policies:
        raise IrsimGymError(f"an arena needs policies\n{cure_of()}")
    request, methods, folder = requested_evaluation(request, policies, split, out, overwrite, "arena")
    chosen: dict[str, Any] = {"levels": levels, "split": split, "replays": replays, "overwrite": overwrite}
    contest = play(policies=methods, folder=folder, **vars(request), **chosen)
    print_evaluation(contest.evaluation)
    print(f"rows, figures and table: {folder}\npage: {contest.page}")


def robustness(
    scenario: opt.Scenario,
    policies: Annotated[list[str], typer.Argument(help=opt.HELP["robustness policies"])],
    factors: Annotated[str | None, typer.Option(metavar="FACTOR[,...]", help=opt.HELP["robustness factors"])] = None,
    levels: opt.Levels = 500,
    split: opt.Split = "test",
    task: opt.Task = None,
    out: Annotated[Path | None, typer.Option(help=opt.HELP["robustness out"])] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help=opt.HELP["robustness overwrite"])] = False,
    team: opt.Team = False,
    settings: opt.Given = None,
    perturb: opt.Perturbed = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Play the same levels with stronger and stronger disturbances: curves, and the strengths that cost 5 points.

    The same command continues an interrupted run.
    """
    from irsim_gym.cli.work.commands import requested_evaluation
    from irsim_gym.evaluation.curves.robustness import robustness as play

    request = scenario_request(scenario, task, team, settings, lenient, perturb)
    request, methods, folder = requested_evaluation(request, policies, split, out, True, "robustness")
    names = None if factors is None else factors.split(",")
    chosen: dict[str, Any] = {"levels": levels, "split": split, "overwrite": overwrite, "factors": names}
    print(play(policies=methods, folder=folder, **vars(request), **chosen))
    print(f"rows, tables and figure: {folder}")
