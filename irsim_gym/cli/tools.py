"""Helpers of several commands: parsing parameters, and printing tables."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import typer

from irsim_gym.base.errors import IrsimGymError, suggestion

if TYPE_CHECKING:
    from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest

LINE = 100


def print_shipped() -> None:
    """Print the shipped scenarios, benchmarks and tasks: summary, number of robots, and parameters."""
    from irsim_gym.envs.gymnasium.registration import env_id
    from irsim_gym.scenario.reference.summary import first_sentence, summarize_file
    from irsim_gym.scenario.specs.library import configs_folder, names

    width = max(len(name) for section in ("scenarios", "benchmarks", "tasks") for name in names(section))
    for section, note in (
        ("scenarios", f"in gymnasium.make: {env_id('NAME')}; with several robots, all may learn as a team"),
        ("benchmarks", "scenarios too, evaluated by `irsim-gym suite`"),
    ):
        print(f"{section} in {configs_folder() / section}")
        print(f"({note})")
        for name, file in names(section).items():
            summary = summarize_file(file)
            robots = f"{summary.robots} robots" if summary.robots > 1 else ""
            print(_row(f"  {name:<{width}}  {robots:<9}  ", summary.about))
            if summary.parameters:
                values = " ".join(f"--set {key}={value}" for key, value in summary.parameters.items())
                print(f"  {'':<{width}}  {'':<9}  {values}")
    print(f"tasks in {configs_folder() / 'tasks'}")
    for name, file in names("tasks").items():
        print(_row(f"  {name:<{width}}  ", first_sentence(file)))


def _row(head: str, about: str) -> str:
    return f"{head}{shorten(about, LINE - len(head), placeholder=' ...')}".rstrip()


def read_count(text: str) -> int:
    """Return a whole number from 1 on, which may be written as 1_000_000, 1,000,000 or 1e6.

    Raises:
        BadParameter: It is not one.
    """
    try:
        number = float(text.replace(",", "").replace("_", ""))
    except ValueError:
        number = 0.0
    if not (1.0 <= number < 2.0**53 and number.is_integer()):
        raise typer.BadParameter(f"must be a whole number >= 1, such as 500000, 500_000 or 5e5, got '{text}'")
    return int(number)


def read_changes(settings: Sequence[str] | None) -> dict[str, str]:
    """Return the values of ``--hp KEY=VALUE`` as text.

    Raises:
        IrsimGymError: If one is not of this form, or a key appears twice.
    """
    return _pairs(settings, "--hp", "KEY=VALUE, e.g. --hp learning_rate=1e-3")


def read_topics(settings: Sequence[str] | None) -> dict[str, str]:
    """Return the values of ``--topic ROLE=TOPIC`` as text.

    Raises:
        IrsimGymError: If one is not of this form, or a role appears twice.
    """
    return _pairs(settings, "--topic", "ROLE=TOPIC, e.g. --topic scan=/front/scan")


def _pairs(settings: Sequence[str] | None, option: str, form: str) -> dict[str, str]:
    pairs: dict[str, str] = {}
    for text in settings or ():
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise IrsimGymError(f"{option}: write {form}, got '{text}'")
        if name.strip() in pairs:
            raise IrsimGymError(f"{option}: '{name.strip()}' is given twice")
        pairs[name.strip()] = value.strip()
    return pairs


def read_parameters(
    settings: Sequence[str] | None, perturbed: Sequence[str] | None = None, shield: str | None = None
) -> dict[str, Any]:
    """Return the values of ``--set name=value``, ``--perturb`` and ``--shield`` as text. The scenario converts them.

    Raises:
        IrsimGymError: If a setting is not of the form ``name=value``, a name appears twice, or it is not allowed.
    """
    parameters: dict[str, Any] = _pairs(settings, "--set", "NAME=VALUE, e.g. --set n_robots=8")
    if parameters or perturbed or shield:
        from irsim_gym.scenario.reading.parameters import BESIDE, PERTURBED, SHIELDED, is_free
    for name in parameters:
        if not is_free(name) and name not in BESIDE:
            raise IrsimGymError(f"--set: '{name}' is no parameter of a scenario, but an argument of environments")
    parameters |= {SHIELDED: shield} if shield else {}
    return {**parameters, PERTURBED: "; ".join(perturbed)} if perturbed else parameters


def scenario_request(
    scenario: str,
    task: str | None,
    team: bool,
    settings: Sequence[str] | None,
    lenient: bool,
    perturbed: Sequence[str] | None = None,
    shield: str | None = None,
) -> ScenarioRequest:
    """Return a scenario with its task, as options of a command ask for it."""
    from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest

    return ScenarioRequest(scenario, task, team, read_parameters(settings, perturbed, shield), not lenient)


def print_options(name: str) -> None:
    """Print the kinds of a family, one line each, or the options of a section or kind as tables.

    Args:
        name: A family such as ``reward``, or a section or kind such as ``world``, ``rvo`` or ``behavior rvo``.

    Raises:
        IrsimGymError: If there is no such section or kind. The message suggests a similar name.
    """
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from irsim_gym.base.families import every
    from irsim_gym.scenario.reference.option_tables import find_family, kind_summaries, option_tables

    family = find_family(name)
    if family is not None:
        kinds = kind_summaries(family)
        width = max(map(len, kinds))
        for kind, about in kinds.items():
            print(f"{kind:<{width}}  {about}")
        return
    tables = dict(option_tables())
    names = {title: {title, title.rsplit(" ", 1)[-1], *title.split(", ")} for title in tables}
    chosen = [title for title, titles in names.items() if name in titles]
    if not chosen:
        near = suggestion(name, sorted({*set().union(*names.values()), *(member.family for member in every())}))
        raise IrsimGymError(f"no section or kind named '{name}'{near}; `irsim-gym options` prints all")
    console = Console()
    for title in chosen:
        table = Table(title=title, title_justify="left")
        for head in ("key", "default", "allowed", "meaning"):
            table.add_column(Text(head), no_wrap=head == "key", ratio=2 if head == "meaning" else None)
        for row in tables[title]:
            default = f"{row.default} {row.unit and f'[{row.unit}]'}".strip()
            table.add_row(*map(Text, (row.key, default, row.allowed, f"{row.meaning} {row.consequence}")))
        console.print(table if tables[title] else f"{title}: no options", markup=False, highlight=False)
