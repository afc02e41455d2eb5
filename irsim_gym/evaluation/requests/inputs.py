"""What a command was given is checked before anything is played, and all problems are reported together."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from irsim_gym.base.errors import IrsimGymError, report_together
from irsim_gym.evaluation.policies.reference_policies import is_named_policy
from irsim_gym.evaluation.requests.methods import read_methods
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import load_policy, policy_file
from irsim_gym.evaluation.saved_policies.policy_places import UnknownPolicyError, all_unknown, check_file, read_each
from irsim_gym.scenario.specs import library
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.scenario.text.source import read_file
from irsim_gym.tasks import load_task
from irsim_gym.tasks.episodes.levels import check_split

Check = Callable[[], object]


def check_inputs(
    asked: ScenarioRequest,
    *further: Check,
    policies: Sequence[str] = (),
    split: str | None = None,
    folder: Path | None = None,
) -> None:
    """Check the arguments that commands share.

    Args:
        asked: The scenario with its task. The scenario's own task is not checked.
        *further: Checks of the command's own; each raises an ``IrsimGymError``.
        policies: Policies as on the command line, with ``NAME=POLICY,POLICY`` for several seeds.
        split: Split of the levels; None where there is none.
        folder: Folder for results, which need not exist.

    Raises:
        IrsimGymError: The only problem, or ``SeveralProblemsError`` with all of them.
    """
    rest = (lambda: None if split is None else check_split(split), lambda: check_folder(folder), *further)
    report_together(*world_checks(asked), lambda: check_policies(policies), *rest)


def world_checks(asked: ScenarioRequest) -> Iterator[Check]:
    """Yield the checks of a scenario and of its task. Where the scenario cannot be read, the task's file still is."""
    loaded: list[Scenario] = []
    yield lambda: loaded.append(asked.load(warn=False))
    task = asked.task
    if isinstance(task, str | Path):
        yield lambda: load_task(loaded[0], task, team=asked.team) if loaded else read_file(library.find(task, "tasks"))


def check_policies(texts: Sequence[str]) -> None:
    """Check that policies exist and that their files can be read.

    Args:
        texts: Policies as on the command line.

    Raises:
        IrsimGymError: The problems of all of them.
    """
    sources = [source for method in read_methods(texts) for source in method.sources]
    checks, missing = read_each(_reading, sources)
    report_together(*([lambda: _refuse(missing)] if missing else []), *checks)


def _reading(source: str) -> Check:
    """Return the check that reads a policy; raise if there is no such policy."""
    if is_named_policy(source):
        return lambda: load_policy(source)
    file = policy_file(source)
    return lambda: check_file(file)


def _refuse(missing: Sequence[UnknownPolicyError]) -> None:
    raise all_unknown(missing)


def check_trained(source: str | Path) -> None:
    """Check that a source is a policy with weights, and that its file can be read.

    Raises:
        IrsimGymError: If it is a behaviour, or there is no such policy.
    """
    if is_named_policy(source):
        raise IrsimGymError(f"{source} is a behavior, which has no weights: name the folder of a run or a policy.zip")
    check_file(policy_file(source))


def check_folder(folder: Path | None) -> None:
    """Check that results can be written into a folder, which need not exist.

    Raises:
        IrsimGymError: If it is a file, or below one.
    """
    if folder is None:
        return
    file = next((place for place in (folder, *folder.parents) if place.exists() and not place.is_dir()), None)
    if file is not None:
        raise IrsimGymError(f"--out names a folder for the results, and {file} is a file")
