"""The commands ``irsim-gym export``, ``fit`` and ``bag``."""

from pathlib import Path
from typing import Annotated

import typer

from irsim_gym.base.extras import require
from irsim_gym.cli import completion as cli_completion
from irsim_gym.cli import options as opt
from irsim_gym.cli.options import MOST_LEVELS, Given, Imports, Task
from irsim_gym.cli.tools import read_parameters, read_topics, scenario_request

bag = typer.Typer(
    help="Bags of ROS without ROS: write them, replay them through an export, and learn of a robot from them.",
    no_args_is_help=True,
    add_completion=False,
)
BagFile = Annotated[
    Path, typer.Argument(metavar="BAG", help="Folder of a bag of ROS 2, its .mcap or .db3 file, or a .bag of ROS 1.")
]
Topics = Annotated[
    list[str] | None,
    typer.Option(
        "--topic",
        metavar="ROLE=TOPIC",
        help="Topic of a role (scan, odometry, command, goal, path), if not as usual; may be repeated.",
    ),
]
Zeros = Annotated[bool, typer.Option("--zeros", help="The scanner reports 0 where nothing is in range.")]


def export(
    policy: Annotated[
        str,
        typer.Argument(
            help="Name of a shipped policy, a run's folder, a policy.zip or an exported .npz file.",
            autocompletion=cli_completion.policies,
        ),
    ],
    out: Annotated[Path, typer.Option(help="Folder for the files.")],
    predict: Annotated[
        float,
        typer.Option(min=0.0, max=2.0, help="Time from measuring until a new command acts [s]; the graph predicts it."),
    ] = 0.0,
    period: Annotated[
        float | None, typer.Option(min=0.001, max=10.0, help="Time between commands [s], if not as trained.")
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option(
            help="Scenario with the robot and its scanner, instead of that of the training.",
            autocompletion=cli_completion.scenarios,
        ),
    ] = None,
    node: Annotated[
        str | None, typer.Option(help="ros1 or ros2: make the folder a package of it, with a node and a launch file.")
    ] = None,
    bodies: Annotated[
        str | None, typer.Option(help="tracked: the robot's own tracker gives the other bodies that a policy sees.")
    ] = None,
    levels: Annotated[int, typer.Option(min=1, max=MOST_LEVELS, help="Number of test levels that both play.")] = 50,
    task: Task = None,
    given: Given = None,
    modules: Imports = None,
) -> None:
    """Write a policy for a robot: one ONNX file from raw messages to commands, a contract, a driver and a check.

    The policy and the graph play the same levels. Nothing is written if their commands differ by more than 1e-5.
    """
    require("robot", "irsim-gym export")
    from irsim_gym.base.errors import IrsimGymError
    from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
    from irsim_gym.robot.export import export_for_robot

    if scenario is None and (given or task):
        raise IrsimGymError("--set and --task go with --scenario")
    asked = None if scenario is None else ScenarioRequest(scenario, task, False, read_parameters(given))
    made = export_for_robot(
        policy, out, predict=predict, period=period, asked=asked, levels=levels, node=node, bodies=bodies
    )
    size = (made.folder / "policy.onnx").stat().st_size / 1000
    if made.contract.seen_map:
        print("not one file: way_on_seen_map, which perceive.py finds beside the graph")
    print(
        f"{made.folder}: {made.n_nodes} nodes, {size:.0f} kB; needs {', '.join(made.contract.needs)}\n"
        f"{made.n_commands:,} commands of {levels} levels differ by {made.difference:.1e} at most; "
        f"{100 * made.contract.results.success:.1f} % solved"
    )


Listed = list[str] | None


def fit(
    folder: Annotated[Path, typer.Argument(help="Folder of an export.")],
    scanner: Annotated[
        Listed, typer.Option(help="Another scanner: beams=360,range=3.5,fov=270deg, or some of these; may be repeated.")
    ] = None,
    mount: Annotated[
        Listed, typer.Option(help="Another place of the scanner: x=0.1,y=0,turn=90deg, or some of these; likewise.")
    ] = None,
    period: Annotated[
        list[float] | None,
        typer.Option(min=0.001, max=10.0, help="Another time between commands in seconds; likewise."),
    ] = None,
    radius: Annotated[
        list[float] | None,
        typer.Option(min=0.001, max=100.0, help="Another radius of a round robot in metres; likewise."),
    ] = None,
    robot: Annotated[
        Listed, typer.Option(help="A preset with all of its values, such as turtlebot4; likewise.")
    ] = None,
    levels: Annotated[int, typer.Option(min=100, max=MOST_LEVELS, help="Number of test levels for each.")] = 200,
    modules: Imports = None,
) -> None:
    """Play an exported policy with other scanners, mounts, periods and sizes, and note in its contract which fit.

    A robot fits if the policy solves at most 2 points less than with that of the contract, on the same levels. The
    driver refuses other scanners. Without options, scanners of 90 and 360 beams, of 3.5 and 12 m and of 270 degrees are
    played, the poorest of these together, and half and twice the period.
    """
    require("robot", "irsim-gym fit")
    from irsim_gym.evaluation.protocol.tables import figure_table, print_table
    from irsim_gym.robot import fitting

    asked = [fitting.read_values("--scanner", text, fitting.SCANNER) for text in scanner or ()]
    asked += [fitting.read_values("--mount", text, fitting.MOUNT) for text in mount or ()]
    asked += [{"period": one} for one in period or ()] + [{"radius": one} for one in radius or ()]
    variants = [fitting.Variant(fitting.told(values), values) for values in asked]
    variants += [fitting.preset_variant(name) for name in robot or ()]
    rows = [one.cells for one in fitting.fit(folder, variants, levels)]
    print_table(figure_table(f"{folder}, {levels} test levels", ("robot", "success [%]", "fits"), rows))
    print(f"{folder / 'contract.json'} holds the tested values")


@bag.command("write")
def write_bag(
    scenario: opt.Scenario,
    policy: Annotated[
        str,
        typer.Argument(
            help="A shipped policy, a run's folder, a policy.zip or a behavior.", autocompletion=cli_completion.policies
        ),
    ],
    out: Annotated[Path, typer.Argument(metavar="OUT", help="Folder of the new bag (MCAP).")],
    level: Annotated[int, typer.Option("--level", "--seed", min=0, max=opt.LAST_LEVEL, help="The level.")] = 0,
    split: opt.Split = "test",
    task: Task = None,
    given: Given = None,
    modules: Imports = None,
) -> None:
    """Write an episode of the simulator as a bag of ROS 2: /scan, /odom, /goal_pose and /cmd_vel."""
    require("robot", "irsim-gym bag")
    from irsim_gym.robot.bags.write import write_bag

    counts = write_bag(scenario_request(scenario, task, False, given, False), policy, out, level, split)
    print(f"{out}: {', '.join(f'{count} {topic}' for topic, count in counts.items())}")


@bag.command("check")
def check_bag(
    file: BagFile,
    export: Annotated[Path, typer.Argument(metavar="EXPORT", help="Folder that irsim-gym export wrote.")],
    out: Annotated[Path | None, typer.Option(help="Picture to write, .png (default: BAG-check.png).")] = None,
    topics: Topics = None,
    zeros: Zeros = False,
) -> None:
    """Replay a bag through an export: commands beside the recorded ones, ages, lost beams, and each stop."""
    require("robot", "irsim-gym bag")
    from irsim_gym.robot.bags.check import check_bag, report
    from irsim_gym.robot.bags.picture import draw_check
    from irsim_gym.robot.bags.read import read_bag

    picture, found = out or Path(f"{file.stem}-check.png"), read_bag(file, read_topics(topics))
    replay = check_bag(found, export, "zero" if zeros else "")
    draw_check(picture, replay, f"{file.name} through {export.name}")
    print(*report(replay, found), picture, sep="\n")


@bag.command("fit")
def fit_bag(file: BagFile, topics: Topics = None, zeros: Zeros = False) -> None:
    """Print what a bag says of a robot as a section of a scenario: latency, lag of the drive, noise, lost beams."""
    require("robot", "irsim-gym bag")
    from irsim_gym.robot.bags.fit import fit_bag, section
    from irsim_gym.robot.bags.read import read_bag

    found = read_bag(file, read_topics(topics))
    print(*section(fit_bag(found, "zero" if zeros else ""), found), sep="\n")
