"""The command ``irsim-gym export``."""

from pathlib import Path
from typing import Annotated

import typer

from irsim_gym.base.extras import require
from irsim_gym.cli import completion as cli_completion
from irsim_gym.cli.options import MOST_LEVELS, Given, Imports, Task
from irsim_gym.cli.tools import read_parameters


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
    made = export_for_robot(policy, out, predict=predict, period=period, asked=asked, levels=levels)
    size = (made.folder / "policy.onnx").stat().st_size / 1000
    if made.contract.seen_map:
        print("not one file: way_on_seen_map, which perceive.py finds beside the graph")
    print(
        f"{made.folder}: {made.n_nodes} nodes, {size:.0f} kB; needs {', '.join(made.contract.needs)}\n"
        f"{made.n_commands:,} commands of {levels} levels differ by {made.difference:.1e} at most; "
        f"{100 * made.contract.results.success:.1f} % solved"
    )
