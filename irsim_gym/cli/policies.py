"""The command ``irsim-gym policies``."""

from pathlib import Path
from typing import Annotated

import typer

from irsim_gym.base.extras import require
from irsim_gym.cli.options import HELP, Imports, Levels

policies = typer.Typer(help="The shipped policies: list them, show their cards, export policies.", no_args_is_help=True)


@policies.command("list")
def list_policies() -> None:
    """List the shipped policies: where each was trained, and how good it is."""
    from irsim_gym.evaluation.saved_policies.shelf_tables import print_shelf

    print_shelf()


@policies.command("show")
def show_policy(
    policy: Annotated[str, typer.Argument(help=HELP["show_policy policy"])],
    as_json: Annotated[bool, typer.Option("--json", help=HELP["show_policy as_json"])] = False,
) -> None:
    """Print the card of a policy: task, observation, network, training, results, weaknesses."""
    from irsim_gym.evaluation.saved_policies.shelf_tables import print_card

    print_card(policy, as_json=as_json)


@policies.command("export")
def export_policy(
    source: Annotated[str, typer.Argument(metavar="RUN", help=HELP["export_policy source"])],
    name: Annotated[str, typer.Argument(help=HELP["export_policy name"])],
    out: Annotated[Path, typer.Option(help=HELP["export_policy out"])] = Path(),
    results: Annotated[list[Path] | None, typer.Option(help=HELP["export_policy results"])] = None,
    levels: Levels = 1000,
    weakness: Annotated[list[str] | None, typer.Option(help=HELP["export_policy weakness"])] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help=HELP["export_policy overwrite"])] = False,
    modules: Imports = None,
) -> None:
    """Write a trained policy as a small file of numbers, with a card. Loading it needs no PyTorch and runs no code."""
    require("train", "irsim-gym policies export")
    from irsim_gym.training.export.exporting import export

    chosen = {"results": results or (), "levels": levels, "weaknesses": weakness or (), "overwrite": overwrite}
    file = export(Path(source), name, out, **chosen)  # type: ignore[arg-type]
    print(f"policy: {file}\ncard: {file.with_suffix('.json')}")
