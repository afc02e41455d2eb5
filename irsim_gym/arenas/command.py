"""The command ``irsim-gym arena``."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from irsim_gym.arenas.contest import arena
from irsim_gym.arenas.entrants import check_entrants
from irsim_gym.evaluation.tables import legend, print_table
from irsim_gym.training.folders import evaluation_folder
from irsim_gym.training.inputs import check_inputs
from irsim_gym.training.interruption import ctrl_c_as_error
from irsim_gym.training.remembered import as_trained
from irsim_gym.training.scenario_request import ScenarioRequest


def run_arena(
    asked: ScenarioRequest,
    policies: Sequence[str],
    out: Path | None,
    *,
    split: str,
    resume: bool,
    overwrite: bool,
    **chosen: Any,
) -> None:
    """Play an arena, and print its tables and the path of its page.

    ``out`` is the folder of the results, None for one in ``runs``; the others are arguments of ``arena``.

    Raises:
        TrainingInterruptedError: If the user presses Ctrl-C; the rows of finished policies are on disk.
    """
    check_inputs(asked, partial(check_entrants, policies), policies=policies, split=split, folder=out)
    asked = as_trained(asked, policies)
    named = str(asked.scenario), split, asked.parameters, asked.team
    folder = out or evaluation_folder(*named, overwrite=overwrite, resume=resume, kind="arena")
    kept = f"stopped; policies that have finished are in {folder}. To continue, run the same command with --resume."
    with ctrl_c_as_error(kept):
        how: dict[str, Any] = {"split": split, "resume": resume, "overwrite": overwrite, **chosen}
        found = arena(policies=policies, folder=folder, **vars(asked), **how)
    tables = found.standings.tables(found.title)
    for table in tables:
        print_table(table)
    print(legend(tables))
    print(f"rows, figures and table: {folder}")
    print(f"page: {found.page}")
