"""Several scenarios that one policy learns together: notation, YAML files, and shares of the worlds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from irsim_gym.base.errors import IrsimGymError, ScenarioError, UnknownNameError, UnknownParameterError
from irsim_gym.base.options import kind, option
from irsim_gym.evaluation.saved_policies.algorithms import find_algorithm
from irsim_gym.scenario.checking.validation import Report, build
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.specs.ids import scenario_name
from irsim_gym.scenario.specs.library import SUFFIXES, every_scenario, find, names
from irsim_gym.scenario.text.source import Place, read_file

SHARE = "share"
"""Name of the option with a scenario's weight."""
MIXTURE = "mixture"
"""Key that tells a mixture file from a scenario."""


@dataclass(frozen=True)
class MixturePart:
    """One scenario of a mixture.

    Attributes:
        scenario: Shipped name, environment id, or path of a scenario file.
        parameters: Values of its parameters by name.
        share: Weight of the scenario. Its share of the worlds is its weight divided by the sum of all weights.
    """

    scenario: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    share: float = 1.0

    @property
    def label(self) -> str:
        """Name of the scenario with its share and its parameters, for the name of a folder."""
        share = [] if self.share == 1.0 else [f"{SHARE}={self.share:g}"]
        return "-".join([Path(self.scenario).stem, *share, *(f"{key}={at}" for key, at in self.parameters.items())])

    def to_plain(self) -> dict[str, Any]:
        """Return the part as plain data."""
        return {"scenario": self.scenario, "parameters": dict(self.parameters), "share": self.share}


def read_part(text: str) -> MixturePart:
    """Return the part that a text of the form ``SCENARIO[:share=WEIGHT][:PARAMETER=VALUE]...`` describes.

    Raises:
        IrsimGymError: If the text has another form.
    """
    scenario, *options = text.split(":")
    while options and "=" not in options[0]:  # a path with a colon
        scenario = f"{scenario}:{options.pop(0)}"
    options_read: dict[str, str] = {}
    for option_text in options:
        name, equals, value = option_text.partition("=")
        if not equals or not name or name in options_read:
            raise IrsimGymError(f"'{text}': write SCENARIO:NAME=VALUE:..., each name once, got '{option_text}'")
        options_read[name] = value
    return MixturePart(scenario, options_read, _weight(text, options_read.pop(SHARE, "1")))


def _weight(text: str, value: str) -> float:
    try:
        weight = float(value)
    except ValueError:
        weight = 0.0
    if not 0.0 < weight < float("inf"):
        raise IrsimGymError(f"'{text}': share must be a number > 0, the weight of the scenario, got '{value}'")
    return weight


def shared_worlds(shares: Sequence[float], n_worlds: int) -> list[int]:
    """Return the number of worlds of each scenario. Each gets its share of all worlds, and at least one.

    Args:
        shares: Weights of the scenarios.
        n_worlds: Number of all worlds.

    Raises:
        IrsimGymError: If there are fewer worlds than scenarios.
    """
    if n_worlds < len(shares):
        raise IrsimGymError(f"a mixture of {len(shares)} scenarios needs at least as many worlds: n_envs is {n_worlds}")
    exact = [share / sum(shares) * n_worlds for share in shares]
    counts = [max(1, int(number)) for number in exact]
    while sum(counts) != n_worlds:
        step = 1 if sum(counts) < n_worlds else -1
        open_ones = [k for k in range(len(counts)) if step > 0 or counts[k] > 1]
        counts[max(open_ones, key=lambda k: step * (exact[k] - counts[k]))] += step
    return counts


@dataclass(frozen=True)
class Mixture:
    """Several scenarios for one policy, as a command or a file names them.

    Attributes:
        parts: The scenarios.
        name: Name of the file; None without one.
        task: Task of all of them; None for the scenarios' own.
        algorithm: Name of the algorithm; None for the default.
        hyperparameters: Path of a hyper-parameter file; None for the shipped one.
    """

    parts: tuple[MixturePart, ...]
    name: str | None = None
    task: str | None = None
    algorithm: str | None = None
    hyperparameters: Path | None = None


@kind
class _MixtureFile:
    """The content of a mixture file."""

    mixture: tuple[Any, ...] = option(min_length=1, meaning="Scenarios: names, or mappings with `scenario`.")
    task: str | None = option(None, min_length=1, meaning="Task of all scenarios.")
    algorithm: str | None = option(None, min_length=1, meaning="Name of the algorithm.")
    hyperparameters: str | None = option(None, min_length=1, meaning="Path of a hyper-parameter file.")


@kind
class _FilePart:
    """One scenario in a mixture file."""

    scenario: str = option(min_length=1, meaning="Name or path of the scenario.")
    share: float = option(1.0, gt=0.0, meaning="Weight of the scenario.")
    parameters: dict[str, Any] = option({}, meaning="Values of its parameters by name.")


def requested_mixture(scenarios: Sequence[str], is_mixture: bool) -> Mixture | None:
    """Return the mixture that ``irsim-gym train`` is to train; None for a single scenario.

    Args:
        scenarios: The names on the command line, of which one may be a mixture file.
        is_mixture: Whether ``--mixture`` is given.

    Raises:
        ScenarioError: If a mixture file is invalid. The message lists every problem with its line.
        IrsimGymError: If there are several scenarios without ``--mixture``, or a file among them.
    """
    files = [file for file in map(mixture_file, scenarios) if file is not None]
    if files and len(scenarios) > 1:
        raise IrsimGymError(f"{files[0]} is a mixture of its own: train it alone, got {', '.join(scenarios)}")
    if files:
        return read_mixture(files[0])
    if is_mixture:
        return Mixture(tuple(map(read_part, scenarios)))
    if len(scenarios) > 1:
        raise IrsimGymError(f"train takes one scenario, got {', '.join(scenarios)}: --mixture trains one policy in all")
    return None


def mixture_file(name: str) -> Path | None:
    """Return the file of a shipped mixture's name or of a path; None if it is no mixture."""
    shipped = names("mixtures")
    if name in shipped and name not in every_scenario():
        return shipped[name]
    file = Path(name)
    if file.suffix not in SUFFIXES or not file.is_file():
        return None
    data = read_file(file).data
    return file if isinstance(data, Mapping) and MIXTURE in data else None


def read_mixture(file: Path) -> Mixture:
    """Read a mixture file. Paths in it are relative to its folder.

    Raises:
        ScenarioError: If the file is invalid. The message lists every problem with its line.
    """
    report = Report.of_file(file)
    file_part, listed = build(_MixtureFile, report.mapping, (), report), report.mapping.get(MIXTURE)
    parts = [_part(one, (MIXTURE, k), file, report) for k, one in enumerate(listed if isinstance(listed, list) else ())]
    for key, check in (("task", partial(find, section="tasks")), ("algorithm", find_algorithm)):
        try:
            check(getattr(file_part, key)) if getattr(file_part, key, None) is not None else None
        except UnknownNameError as error:
            report.add((key,), str(error))
    report.check()
    assert file_part is not None
    return Mixture(
        tuple(part for part in parts if part is not None),
        file.stem,
        None if file_part.task is None else _beside(file, file_part.task),
        file_part.algorithm,
        None if file_part.hyperparameters is None else file.parent / file_part.hyperparameters,
    )


def _part(item: object, place: Place, file: Path, report: Report) -> MixturePart | None:
    """Return one scenario: a name, or a mapping with ``scenario``, ``share`` and ``parameters``."""
    is_name = isinstance(item, str)
    item_part = build(_FilePart, {"scenario": item} if is_name else item, place, report)
    if item_part is None:
        return None
    part = MixturePart(_beside(file, item_part.scenario), item_part.parameters, item_part.share)
    return _known(part, place, place if is_name else (*place, "scenario"), report)


def _known(part: MixturePart, place: Place, named: Place, report: Report) -> MixturePart:
    """Return a part, after reporting its unknown scenario, or what its scenario does not take."""
    try:
        load_scenario(scenario_name(part.scenario), part.parameters, strict=False, warn=False)
    except UnknownParameterError as error:
        report.add((*place, "parameters", error.name), str(error))
    except UnknownNameError as error:
        report.add(named, str(error))
    except ScenarioError as error:  # mistakes of the scenario's own file are told with their lines when it is loaded
        for problem in error.problems:
            name = problem.path.removeprefix("parameters.")
            if name in part.parameters:
                report.add((*place, "parameters", name), problem.message)
    return part


def _beside(file: Path, name: str) -> str:
    """Return a name unchanged, and a path as seen from where the command runs."""
    return str(file.parent / name) if Path(name).suffix in SUFFIXES else name
