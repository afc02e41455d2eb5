"""The command ``irsim-gym run``."""

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Any

import typer

from irsim_gym.base.errors import IrsimGymError, report_together
from irsim_gym.cli.options import HELP, Given, Imports, Lenient, ReplaceFile
from irsim_gym.cli.tools import read_parameters


def run_by_itself(
    scenario: Annotated[str, typer.Argument(help=HELP["run_by_itself scenario"])],
    steps: Annotated[int, typer.Option(min=1, help=HELP["run_by_itself steps"])] = 500,
    seed: Annotated[int, typer.Option(min=0, help=HELP["run_by_itself seed"])] = 0,
    out: Annotated[Path | None, typer.Option("--out", "--film", help=HELP["run_by_itself out"])] = None,
    overwrite: ReplaceFile = False,
    settings: Given = None,
    lenient: Lenient = False,
    modules: Imports = None,
) -> None:
    """Run a file with its own behaviours, without learning, and print the status of its robots at the end."""
    from irsim_gym.evaluation.protocol.progress_bars import counting
    from irsim_gym.live.world import load
    from irsim_gym.scenario.reading.load import load_scenario

    parameters = read_parameters(settings)
    how: dict[str, Any] = {"strict": not lenient, "warn": False, "may_pend": True}
    report_together(lambda: _check_film(out, overwrite), lambda: load_scenario(scenario, parameters, **how))
    chosen: dict[str, Any] = {"record": out is not None, "strict": not lenient}
    with load(scenario, seed=seed, **chosen, **parameters) as world:
        world.resume()
        with counting("driving", steps) if out is not None else nullcontext(lambda _: None) as advance:
            while world.count < steps and not world.done():
                world.step()
                advance(1)
        print(f"{world.status} after {world.time:g} s")
        for robot in world.robots:
            flag = "arrived" if robot.arrived else "collided" if robot.collided else "under way"
            print(f"{robot.name}: {flag} at ({', '.join(f'{value:.2f}' for value in robot.state)})")
        if out is not None:
            print(world.save_html(out) if out.suffix.lower() == ".html" else world.save_animation(out))


def _check_film(film: Path | None, overwrite: bool) -> None:
    from irsim_gym.evaluation.requests.folders import check_free

    if film is not None and film.suffix.lower() not in (".mp4", ".gif", ".html"):
        raise IrsimGymError(f"a film's name ends in .mp4, .gif or .html, got '{film.name}'")
    check_free(film, overwrite)
