"""The command ``irsim-gym``. Each command imports the heavy packages that it needs."""

import gc
import io
import signal
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.extras import require
from irsim_gym.cli import options as opt
from irsim_gym.cli.arena import arena, robustness
from irsim_gym.cli.levels import levels
from irsim_gym.cli.policies import policies as shelf
from irsim_gym.cli.robot import bag, export, fit
from irsim_gym.cli.run import run_by_itself
from irsim_gym.cli.start import new, options, schema
from irsim_gym.cli.suite import suite
from irsim_gym.cli.tools import print_shipped, read_parameters, scenario_request
from irsim_gym.cli.train import train, tune

app = typer.Typer(no_args_is_help=True, pretty_exceptions_enable=False)


app.add_typer(suite, name="suite")
app.add_typer(levels, name="levels")
app.add_typer(shelf, name="policies")
app.add_typer(bag, name="bag")


@app.command("list")
def list_shipped() -> None:
    """List the shipped scenarios, benchmarks and tasks."""
    print_shipped()


@app.command()
def check(
    files: Annotated[list[str], typer.Argument(help=opt.HELP["check files"])],
    team: Annotated[bool, typer.Option("--team", help=opt.HELP["check team"])] = False,
    task: opt.Task = None,
    settings: opt.Given = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Check scenario files and their tasks, and run each for some steps. Print every problem with its line.

    Files run in another process, so a crash is reported like any other problem. For a valid file, the command prints
    its parameters, and notes on allowed but unusual values. The exit status is 1 if a file cannot be used. Notes do
    not change it, nor do reasons why robots cannot learn together (unless --team is given), or why none can learn in a
    file without a section task.
    """
    from irsim_gym.cli.work.check import check_files
    from irsim_gym.cli.work.trial import ReadOptions

    if not check_files(files, ReadOptions(read_parameters(settings), not lenient, task, team)):
        raise typer.Exit(1)


@app.command()
def describe(
    scenario: opt.Scenario,
    task: opt.Task = None,
    as_json: Annotated[bool, typer.Option("--json", help=opt.HELP["describe as_json"])] = False,
    team: Annotated[bool, typer.Option("--team", help=opt.HELP["describe team"])] = False,
    settings: opt.Given = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Describe each number: observations by column, actions, rewards, endings, infos."""
    from irsim_gym.cli.work.describe import describe_scenario

    request = scenario_request(scenario, task, team, settings, lenient)
    describe_scenario(request, as_json=as_json)


app.command()(options)
app.command()(schema)
app.command()(train)
app.command()(tune)
app.command()(export)
app.command()(fit)


@app.command()
def evaluate(
    scenario: opt.Scenario,
    policies: Annotated[list[str] | None, typer.Argument(help=opt.HELP["evaluate policies"])] = None,
    levels: opt.Levels = 1000,
    split: opt.Split = "test",
    task: opt.Task = None,
    out: Annotated[Path | None, typer.Option(help=opt.HELP["evaluate out"])] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help=opt.HELP["evaluate overwrite"])] = False,
    references: Annotated[bool, typer.Option(help=opt.HELP["evaluate references"])] = True,
    team: opt.Team = False,
    settings: opt.Given = None,
    perturb: opt.Perturbed = None,
    shield: opt.Shield = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Evaluate policies on unseen levels, beside random and dash; with --team, whole teams."""
    from irsim_gym.cli.work.commands import run_evaluation

    request = scenario_request(scenario, task, team, settings, lenient, perturb, shield)
    how: dict[str, Any] = {"out": out, "references": references, "overwrite": overwrite}
    run_evaluation(request, policies or [], levels=levels, split=split, **how)


@app.command()
def tracks(
    scenario: opt.Scenario,
    levels: opt.Levels = 50,
    split: opt.Split = "dev",
    settings: opt.Given = None,
    perturb: opt.Perturbed = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Measure how well the observation `tracks` shows what moves, by distance, while the robot drives at random."""
    from irsim_gym.evaluation.comparison.tracking import measure_tracks, tracking_table
    from irsim_gym.evaluation.protocol.tables import print_table

    found = measure_tracks(scenario_request(scenario, None, False, settings, lenient, perturb), levels, split)
    print_table(tracking_table(found))
    rate = found.false / found.minutes
    print(f"false tracks a minute: {rate:.2f}; another track goes on with a body: {found.switches / found.minutes:.2f}")


app.command()(arena)
app.command()(robustness)


@app.command()
def record(
    scenario: opt.Scenario,
    policies: Annotated[list[str], typer.Argument(help=opt.HELP["record policies"])],
    level: Annotated[list[int] | None, typer.Option(min=0, max=opt.LAST_LEVEL, help=opt.HELP["record level"])] = None,
    split: opt.Split = "test",
    task: opt.Task = None,
    out: Annotated[Path | None, typer.Option(help=opt.HELP["record out"])] = None,
    overwrite: opt.ReplaceFile = False,
    html: Annotated[bool, typer.Option("--html", help=opt.HELP["record html"])] = False,
    team: opt.Team = False,
    settings: opt.Given = None,
    perturb: opt.Perturbed = None,
    shield: opt.Shield = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Film policies on the same levels, side by side.

    With --html, write a replay page with scans and rewards for browsers.
    """
    from irsim_gym.cli.work.commands import run_record

    request = scenario_request(scenario, task, team, settings, lenient, perturb, shield)
    run_record(request, policies, level or [0], split, out, "replay" if html else "film", overwrite=overwrite)


@app.command()
def demo(
    out: Annotated[Path, typer.Option(help=opt.HELP["demo out"])] = Path("runs/demo"),
    scenario: Annotated[str, typer.Option(help=opt.HELP["demo scenario"])] = "cluttered_room",
    steps: opt.Steps = None,
    levels: opt.Levels = 1000,
    seed: opt.Seed = 0,
) -> None:
    """Train PPO on cluttered_room, evaluate and film it. After Ctrl-C, the same command resumes."""
    require("train", "irsim-gym demo")
    from irsim_gym.cli.work.demo import run_demo

    run_demo(out, scenario=scenario, steps=steps, levels=levels, seed=seed)


app.command("run")(run_by_itself)
app.command()(new)


@app.command()
def play(
    scenario: opt.Scenario,
    policy: opt.Watched = None,
    out: Annotated[Path | None, typer.Option("--out", "--record", help=opt.HELP["play out"])] = None,
    task: opt.Task = None,
    level: Annotated[
        int, typer.Option("--level", "--seed", min=0, max=opt.LAST_LEVEL, help=opt.HELP["play level"])
    ] = 0,
    split: opt.Split = "train",
    robot: Annotated[str | None, typer.Option(help=opt.HELP["play robot"])] = None,
    speed: Annotated[float, typer.Option(min=0.05, max=20.0, help=opt.HELP["play speed"])] = 1.0,
    given: opt.Given = None,
    perturb: opt.Perturbed = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Drive a robot by hand in a window, level after level, or watch a policy. It lists the keys; esc quits."""
    from irsim_gym.cli.play.manual_play import PlaySettings
    from irsim_gym.cli.play.manual_play import play as play_by_hand

    parameters = read_parameters(given, perturb)
    settings = PlaySettings(scenario, task, robot, level, split, parameters, out, speed, policy, not lenient)
    played = play_by_hand(settings)
    print(", ".join(f"{count} {outcome}" for outcome, count in sorted(played.outcomes.items())) or "no episode ended")
    if played.record is not None:
        print(f"{played.record}: {played.recorded} episode{'' if played.recorded == 1 else 's'}")


@app.command()
def draw(
    scenario: opt.Scenario,
    level: Annotated[int, typer.Option(min=0, max=opt.LAST_LEVEL, help=opt.HELP["draw level"])] = 0,
    split: opt.Split = "dev",
    task: opt.Task = None,
    out: Annotated[Path | None, typer.Option(help=opt.HELP["draw out"])] = None,
    settings: opt.Given = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Draw the start of a level, or write what stands in it as a map of ROS."""
    from irsim_gym.cli.work.inspection import draw_level

    print(draw_level(scenario, level, split, task, out, read_parameters(settings), not lenient))


@app.command()
def warmup(
    scenarios: Annotated[list[str] | None, typer.Argument(help=opt.HELP["warmup scenarios"])] = None,
    task: opt.Task = None,
    lenient: opt.Lenient = False,
    modules: opt.Imports = None,
) -> None:
    """Compile the kernels of scenarios in advance, so that later commands start at once."""
    from irsim_gym.cli.work.warmup import warm_up
    from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
    from irsim_gym.evaluation.suite.members import shipped_suite
    from irsim_gym.scenario.specs.library import scenario_names

    suite = shipped_suite()
    worlds: list[tuple[str, Mapping[str, Any] | None]] = []
    for name in scenarios or scenario_names():
        of_suite = suite.chosen([name]) if name in suite.tiers or name in suite.members else []
        worlds += [(member.scenario, member.parameters) for member in of_suite] or [(name, None)]
    warm_up([ScenarioRequest(name, task, parameters=settings, strict=not lenient) for name, settings in worlds])


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line. Errors of irsim_gym print a message without a traceback.

    Args:
        arguments: The command and its arguments; None for those of the process.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_DFL:  # as the package sets it while it is loaded
        signal.signal(signal.SIGINT, signal.default_int_handler)
    gc.set_threshold(100_000)  # objects of imports stay, so there is little to find among them
    if isinstance(sys.stdout, io.TextIOWrapper):  # the encoding of a redirected output may lack characters
        sys.stdout.reconfigure(errors="replace")
    _guarded(arguments)


def _print_version(is_asked: bool) -> None:
    if is_asked:
        from irsim_gym.base.version import __version__

        print(f"irsim_gym {__version__}")
        raise typer.Exit


@app.callback()
def _general(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help=opt.HELP["_general version"])
    ] = False,
) -> None:
    """Mobile robots in IR-SIM's YAML: check scenarios, train agents, evaluate and film them."""


def _guarded(arguments: Sequence[str] | None) -> None:
    try:
        app(arguments)
    except IrsimGymError as error:
        print(error, *getattr(error, "__notes__", ()), sep="\n", file=sys.stderr)
        sys.exit(128 + error.signal if hasattr(error, "signal") else 1)
    except MemoryError as error:
        print(error or "there is not enough memory", file=sys.stderr)
        sys.exit(1)
    except OSError as error:
        what = "" if error.filename is None else f"cannot use {error.filename}: "
        print(f"{what}{error.strerror or error}", file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
