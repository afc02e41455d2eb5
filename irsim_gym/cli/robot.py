"""The commands ``irsim-gym export``, ``fit`` and ``bag``."""

from pathlib import Path
from typing import Annotated, Any

import typer

from irsim_gym.base.extras import require
from irsim_gym.cli import options as opt
from irsim_gym.cli.tools import read_parameters, read_topics, scenario_request

ABOUT = "Bags of ROS without ROS: write them, replay them through an export, and learn of a robot from them."
bag = typer.Typer(help=ABOUT, no_args_is_help=True, add_completion=False)
BagFile = Annotated[Path, typer.Argument(metavar="BAG", help=opt.HELP["BagFile"])]
Topics = Annotated[list[str] | None, typer.Option("--topic", metavar="ROLE=TOPIC", help=opt.HELP["Topics"])]
Zeros = Annotated[bool, typer.Option("--zeros", help=opt.HELP["Zeros"])]


def export(
    policy: Annotated[str, typer.Argument(help=opt.HELP["export policy"])],
    out: Annotated[Path, typer.Option(help=opt.HELP["export out"])],
    predict: Annotated[float, typer.Option(min=0.0, max=2.0, help=opt.HELP["export predict"])] = 0.0,
    period: Annotated[float | None, typer.Option(min=0.001, max=10.0, help=opt.HELP["export period"])] = None,
    scenario: Annotated[str | None, typer.Option(help=opt.HELP["export scenario"])] = None,
    node: Annotated[str | None, typer.Option(help=opt.HELP["export node"])] = None,
    bodies: Annotated[str | None, typer.Option(help=opt.HELP["export bodies"])] = None,
    shield: opt.Shield = None,
    lag: Annotated[float, typer.Option(min=0.0, max=10.0, help=opt.HELP["export lag"])] = 0.0,
    levels: Annotated[int, typer.Option(min=1, max=opt.MOST_LEVELS, help=opt.HELP["export levels"])] = 50,
    task: opt.Task = None,
    settings: opt.Given = None,
    modules: opt.Imports = None,
) -> None:
    """Write a policy for a robot: one ONNX file from raw messages to commands, a contract, a driver and a check.

    The policy and the graph play the same levels. Nothing is written if their commands differ by more than 1e-5.
    """
    require("robot", "irsim-gym export")
    from irsim_gym.base.errors import IrsimGymError
    from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
    from irsim_gym.robot.export import export_for_robot

    if scenario is None and (settings or task):
        raise IrsimGymError("--set and --task go with --scenario")
    request = None if scenario is None else ScenarioRequest(scenario, task, False, read_parameters(settings))
    how: dict[str, Any] = {"predict": predict, "period": period, "node": node, "bodies": bodies}
    result = export_for_robot(policy, out, request=request, levels=levels, shield=shield, lag=lag, **how)
    size = (result.folder / "policy.onnx").stat().st_size / 1000
    if result.contract.seen_map:
        print("not one file: way_on_seen_map, which perceive.py finds beside the graph")
    print(
        f"{result.folder}: {result.n_nodes} nodes, {size:.0f} kB; needs {', '.join(result.contract.needs)}\n"
        f"{result.n_commands:,} commands of {levels} levels differ by {result.difference:.1e} at most; "
        f"{100 * result.contract.results.success:.1f} % solved"
    )


Listed = list[str] | None


def fit(
    folder: Annotated[Path, typer.Argument(help=opt.HELP["fit folder"])],
    scanner: Annotated[Listed, typer.Option(help=opt.HELP["fit scanner"])] = None,
    mount: Annotated[Listed, typer.Option(help=opt.HELP["fit mount"])] = None,
    period: Annotated[list[float] | None, typer.Option(min=0.001, max=10.0, help=opt.HELP["fit period"])] = None,
    radius: Annotated[list[float] | None, typer.Option(min=0.001, max=100.0, help=opt.HELP["fit radius"])] = None,
    robot: Annotated[Listed, typer.Option(help=opt.HELP["fit robot"])] = None,
    levels: Annotated[int, typer.Option(min=100, max=opt.MOST_LEVELS, help=opt.HELP["fit levels"])] = 200,
    modules: opt.Imports = None,
) -> None:
    """Play an exported policy with other scanners, mounts, periods and sizes, and note in its contract which fit.

    A robot fits if the policy solves at most 2 points less than with that of the contract, on the same levels. The
    driver refuses other scanners. Without options, scanners of 90 and 360 beams, of 3.5 and 12 m and of 270 degrees are
    played, the poorest of these together, and half and twice the period.
    """
    require("robot", "irsim-gym fit")
    from irsim_gym.evaluation.protocol.tables import figure_table, print_table
    from irsim_gym.robot import fitting

    changes = [fitting.read_values("--scanner", text, fitting.SCANNER) for text in scanner or ()]
    changes += [fitting.read_values("--mount", text, fitting.MOUNT) for text in mount or ()]
    changes += [{"period": value} for value in period or ()] + [{"radius": value} for value in radius or ()]
    variants = [fitting.Variant(fitting.told(values), values) for values in changes]
    variants += [fitting.preset_variant(name) for name in robot or ()]
    rows = [row.cells for row in fitting.fit(folder, variants, levels)]
    print_table(figure_table(f"{folder}, {levels} test levels", ("robot", "success [%]", "fits"), rows))
    print(f"{folder / 'contract.json'} holds the tested values")


@bag.command("write")
def write_bag(
    scenario: opt.Scenario,
    policy: Annotated[str, typer.Argument(help=opt.HELP["write_bag policy"])],
    out: Annotated[Path, typer.Argument(metavar="OUT", help=opt.HELP["write_bag out"])],
    level: Annotated[
        int, typer.Option("--level", "--seed", min=0, max=opt.LAST_LEVEL, help=opt.HELP["write_bag level"])
    ] = 0,
    split: opt.Split = "test",
    task: opt.Task = None,
    settings: opt.Given = None,
    modules: opt.Imports = None,
) -> None:
    """Write an episode of the simulator as a bag of ROS 2: /scan, /odom, /goal_pose and /cmd_vel."""
    require("robot", "irsim-gym bag")
    from irsim_gym.robot.bags.write import write_bag

    counts = write_bag(scenario_request(scenario, task, False, settings, False), policy, out, level, split)
    print(f"{out}: {', '.join(f'{count} {topic}' for topic, count in counts.items())}")


@bag.command("check")
def check_bag(
    file: BagFile,
    export: Annotated[Path, typer.Argument(metavar="EXPORT", help=opt.HELP["check_bag export"])],
    out: Annotated[Path | None, typer.Option(help=opt.HELP["check_bag out"])] = None,
    topics: Topics = None,
    zeros: Zeros = False,
) -> None:
    """Replay a bag through an export: commands beside the recorded ones, ages, lost beams, and each stop."""
    require("robot", "irsim-gym bag")
    from irsim_gym.robot.bags.check import check_bag, report
    from irsim_gym.robot.bags.picture import draw_check
    from irsim_gym.robot.bags.read import read_bag

    picture, bag = out or Path(f"{file.stem}-check.png"), read_bag(file, read_topics(topics))
    replay = check_bag(bag, export, "zero" if zeros else "")
    draw_check(picture, replay, f"{file.name} through {export.name}")
    print(*report(replay, bag), picture, sep="\n")


@bag.command("fit")
def fit_bag(file: BagFile, topics: Topics = None, zeros: Zeros = False) -> None:
    """Print what a bag says of a robot as a section of a scenario: latency, lag of the drive, noise, lost beams."""
    require("robot", "irsim-gym bag")
    from irsim_gym.robot.bags.fit import fit_bag, section
    from irsim_gym.robot.bags.read import read_bag

    bag = read_bag(file, read_topics(topics))
    print(*section(fit_bag(bag, "zero" if zeros else ""), bag), sep="\n")
