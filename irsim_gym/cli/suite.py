"""The command ``irsim-gym suite``."""

from pathlib import Path
from typing import Annotated

import typer

from irsim_gym.base.errors import IrsimGymError, report_together
from irsim_gym.base.outside_files import reading
from irsim_gym.cli.options import HELP, Imports, Levels, Split

suite = typer.Typer(help="The benchmark suite: list it, play policies on it, print tables.", no_args_is_help=True)


@suite.command("list")
def list_suite(names: Annotated[list[str] | None, typer.Argument(help=HELP["list_suite names"])] = None) -> None:
    """List benchmarks: id, tiers, what each tests, and its reference results."""
    from irsim_gym.evaluation.suite.listing import print_suite

    print_suite(names or [])


@suite.command("run")
def run_suite(
    names: Annotated[str, typer.Argument(metavar="TIER|BENCHMARK[,...]", help=HELP["run_suite names"])],
    policies: Annotated[list[str], typer.Argument(help=HELP["run_suite policies"])],
    levels: Levels = 1000,
    split: Split = "test",
    latency: Annotated[bool, typer.Option("--latency", help=HELP["run_suite latency"])] = False,
    out: Annotated[Path | None, typer.Option(help=HELP["run_suite out"])] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help=HELP["run_suite overwrite"])] = False,
    modules: Imports = None,
) -> None:
    """Play policies on benchmarks and print the table. The same command continues an interrupted run."""
    from irsim_gym.evaluation.requests.inputs import check_folder, check_policies
    from irsim_gym.evaluation.requests.methods import read_methods
    from irsim_gym.evaluation.suite.members import shipped_suite
    from irsim_gym.evaluation.suite.playing import play_suite
    from irsim_gym.evaluation.suite.suite_tables import markdown
    from irsim_gym.tasks.episodes.levels import check_split

    wanted = [name for name in names.split(",") if name]
    if not wanted:
        raise IrsimGymError("name a tier or a benchmark, such as core; `irsim-gym suite list` shows them")
    report_together(
        lambda: shipped_suite().chosen(wanted),
        lambda: check_policies(policies),
        lambda: check_split(split),
        lambda: check_folder(out),
    )
    members = shipped_suite().chosen(wanted)
    folder = out or Path("runs") / f"suite-{names.replace(',', '-')}"
    chosen = {"latency": latency, "overwrite": overwrite}
    record = play_suite(members, read_methods(policies), folder, levels=levels, split=split, **chosen)
    print(markdown(record))
    print(f"rows and summary: {folder}")


@suite.command("table")
def print_table(folder: Annotated[Path, typer.Argument(help=HELP["print_table folder"])]) -> None:
    """Print the tables of a run, with the conditions of its results."""
    from irsim_gym.evaluation.suite.scores import score_suite
    from irsim_gym.evaluation.suite.suite_record import RECORD, SUMMARY, read_record
    from irsim_gym.evaluation.suite.suite_tables import markdown

    record = read_record(folder)
    with reading(folder / SUMMARY, RECORD):
        score_suite(record, folder)
        tables = markdown(record)
    print(tables)
