"""Where policies are, and what to write where there is none."""

import os
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

from irsim_gym.base.errors import IrsimGymError, nearest
from irsim_gym.base.extras import require
from irsim_gym.evaluation.policies.reference_policies import policy_kinds
from irsim_gym.evaluation.saved_policies.checkpoint_files import POLICY, newest_checkpoint
from irsim_gym.evaluation.saved_policies.run_folder import RunFolder
from irsim_gym.evaluation.saved_policies.shelf import SUFFIX, read_policy, shelf_files

S = TypeVar("S")
T = TypeVar("T")
RUNS = Path("runs")
MOST = 6
"""Largest number of runs that a message lists."""
DEPTH = 2
"""How many folders below ``runs`` a run may be, as one of several seeds is."""


class UnknownPolicyError(IrsimGymError):
    """Raised if there is no policy of a name, and no such file or folder.

    Args:
        source: Name or path.
        problem: Description of the problem, without what is valid.
        cure: What is valid; None for what fits the source.
    """

    def __init__(self, source: str | Path, problem: str, cure: str | None = None) -> None:
        super().__init__(f"{problem}\n{cure_of([source]) if cure is None else cure}")
        self.source, self.problem = source, problem


def runs_below(folder: Path = RUNS, depth: int = DEPTH) -> list[Path]:
    """Return the folders of runs below a folder, in alphabetical order.

    Args:
        folder: The folder, which need not exist.
        depth: How many folders deep a run may be.
    """
    return list(_runs(folder, depth))


def _runs(folder: Path, depth: int) -> Iterator[Path]:
    if not depth or not folder.is_dir():
        return
    for below in sorted(path for path in folder.iterdir() if path.is_dir()):
        if (below / POLICY).is_file() or newest_checkpoint(RunFolder(below).checkpoints) is not None:
            yield below
        else:
            yield from _runs(below, depth - 1)


def is_place(source: str | Path) -> bool:
    """Return whether a source is meant as the path of a file or a folder, rather than as a name."""
    text = str(source)
    return isinstance(source, Path) or "/" in text or os.sep in text or Path(text).suffix != "" or Path(text).exists()


def missing_policy(source: str | Path) -> str:
    """Return what is wrong with a source that is no policy: what was found, and the nearest that there is.

    Args:
        source: Name or path, as ``load_policy`` takes it.
    """
    path = Path(source)
    if path.is_dir():
        return f"no policy at {source}: the folder holds neither {POLICY} nor a checkpoint"
    runs = runs_below()
    if not is_place(source):
        by_name = {name: name for name in (*policy_kinds(), *shelf_files())} | {run.name: str(run) for run in runs}
        near = nearest(str(source), by_name)
        return f"no policy named '{source}'{_meant(None if near is None else by_name[near])}"
    files = {str(run): str(run) for run in runs} | {str(run / POLICY): str(run / POLICY) for run in runs}
    beside = path.parent if path.parent.is_dir() else Path()
    files |= {str(file): str(file) for file in beside.iterdir() if file.suffix in (".zip", SUFFIX)}
    return f"no policy at {source}: no such file or folder{_meant(nearest(str(path), files))}"


def _meant(near: str | None) -> str:
    return "" if near is None else f" (did you mean '{near}'?)"


def cure_of(sources: Sequence[str | Path] = ()) -> str:
    """Return what can be written in place of sources that are no policies, in indented lines.

    Args:
        sources: The sources: paths get the runs that are here, names get the names; none gets both.
    """
    places = [source for source in sources if is_place(source)]
    lines = []
    if places or not sources:
        above = next((Path(source) for source in places if Path(source).is_dir()), RUNS)
        lines.append(_runs_here(runs_below(above) or runs_below()))
    if len(places) < len(sources) or not sources:
        lines += [f"behaviors: {', '.join(policy_kinds())}", f"shipped policies: {', '.join(shelf_files()) or 'none'}"]
    lines.append(f"a policy is the folder of a run, a {POLICY}, a behavior such as dash, or a shipped policy")
    return "\n".join(f"  {line}" for line in lines)


def _runs_here(runs: Sequence[Path]) -> str:
    if not runs:
        return "no run is here yet: irsim-gym train makes one"
    more = f" and {len(runs) - MOST} more" if len(runs) > MOST else ""
    return f"runs here: {', '.join(map(str, runs[:MOST]))}{more}"


def all_unknown(missing: Sequence[UnknownPolicyError]) -> UnknownPolicyError:
    """Return one error for several policies that do not exist, with what is valid once."""
    problems = "\n".join(error.problem for error in missing)
    return UnknownPolicyError(missing[0].source, problems, cure_of([error.source for error in missing]))


def read_each(read: Callable[[S], T], sources: Iterable[S]) -> tuple[list[T], list[UnknownPolicyError]]:
    """Return what a function makes of the sources that exist, and its errors for those that do not."""
    items: list[T] = []
    missing: list[UnknownPolicyError] = []
    for source in sources:
        try:
            items.append(read(source))
        except UnknownPolicyError as error:
            missing.append(error)
    return items, missing


def check_file(file: Path) -> None:
    """Check that a file can be a policy, without loading PyTorch.

    Raises:
        IrsimGymError: If it is no exported policy, or no archive as Stable-Baselines3 writes it.
        MissingExtraError: If Stable-Baselines3 is not installed.
    """
    if file.suffix == SUFFIX:
        read_policy(file)
        return
    require("train", f"{file}: a policy.zip")
    if not zipfile.is_zipfile(file):
        raise IrsimGymError(f"{file} is not a policy of Stable-Baselines3: it is no zip archive")
