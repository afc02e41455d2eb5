"""The shelf on the screen: a table of all policies, and the card of one."""

from collections.abc import Mapping
from pathlib import Path

from rich.text import Text

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.protocol.tables import legend, print_table, titled_table
from irsim_gym.evaluation.saved_policies.cards import CardResult, CardShare, PolicyCard, card_file, read_card
from irsim_gym.evaluation.saved_policies.shelf import SUFFIX, shelf_file, shelf_files, shelf_folder
from irsim_gym.scenario.text.messages import with_parameters


def print_shelf() -> None:
    """Print a row for each shipped policy, with its success under the parameters of its training."""
    table = titled_table(f"policies in {shelf_folder()}")
    for head in ("policy", "trained in", "task", "success [%]", "levels", "needs", "CPU s", "kB"):
        table.add_column(Text(head), no_wrap=head == "policy", justify="right" if head in ("CPU s", "kB") else "left")
    for file in shelf_files().values():
        card = _card(file)
        own = [
            result
            for result in card.results
            if (result.scenario, result.parameters) == (None, card.scenario.parameters)
        ]
        shown = own or card.results
        figures = percent(shown[0].success), f"{shown[0].levels:,} {shown[0].split}"
        cells = (card.name, _trained_in(card, briefly=True), card.scenario.task or "its own", *figures, _needed(card))
        table.add_row(*map(Text, (*cells, f"{card.training.cpu_seconds:.0f}", f"{card.size / 1000:.0f}")))
    print_table(table)
    print(legend([table]))


def print_card(policy: str, *, as_json: bool = False) -> None:
    """Print a card.

    Args:
        policy: Name of a shipped policy, or an exported file.
        as_json: As it stands in its file.

    Raises:
        IrsimGymError: There is no such policy, or it has no card.
    """
    file = Path(policy) if Path(policy).suffix == SUFFIX else shelf_file(policy)
    card = _card(file)
    print(card.model_dump_json(indent=2, by_alias=True) if as_json else "\n".join([*_lines(card), f"file: {file}"]))


def percent(share: CardShare) -> str:
    """Return a share with its interval, in percent."""
    return f"{100 * share.value:.1f} [{100 * share.low:.1f}, {100 * share.high:.1f}]"


def curves_text(curves: Mapping[str, object]) -> str:
    """Return at which strength of each disturbance 5 points are lost: ``latency 0.2 s, slip > 20 %``."""
    return ", ".join(f"{factor} {curve}" for factor, curve in curves.items())


def _card(file: Path) -> PolicyCard:
    card = read_card(file)
    if card is None:
        if not file.is_file():
            raise IrsimGymError(f"no file {file}; `irsim-gym policies list` names the shipped policies")
        raise IrsimGymError(f"{file} has no card beside it: `irsim-gym policies export` writes {card_file(file).name}")
    return card


def _lines(card: PolicyCard) -> list[str]:
    training, action, machine = card.training, card.action, card.training.machine
    choices = "" if action.choices is None else f", {action.choices} choices"
    observed = ", ".join(f"{term.name} {' x '.join(map(str, term.shape))}" for term in card.observation)
    versions = ", ".join(map(" ".join, machine["versions"].items()))
    return [
        f"{card.name}: {training.algorithm.upper()}, trained in {_trained_in(card)}",
        f"task: {card.scenario.task or 'of the scenario'}; hash of scenario and task {card.scenario.sha256[:12]}",
        f"observation: {observed}",
        f"needed on a robot: {_needed(card)}",
        f"action: {action.name} ({'; '.join(action.components)}){choices}",
        *(f"network, {layers}" for layers in card.network.layers),
        f"weights: {card.network.weights:,}; {card.size / 1000:.0f} kB; sha256 {card.sha256[:12]}",
        f"seed: {training.seed} of {', '.join(map(str, training.seeds))}",
        f"training: {training.steps:,} steps, {training.cpu_seconds:.0f} s of CPU time, "
        f"{training.training_seconds:.0f} s on a clock; {machine['processor']}, {versions}",
        *(f"success: {_told(result)}" for result in card.results),
        *([f"5 points of success are lost at: {curves_text(card.robustness)}"] if card.robustness else []),
        *(f"weakness: {sentence}" for sentence in card.weaknesses),
    ]


def _needed(card: PolicyCard) -> str:
    return "not said" if card.needs is None else ", ".join(card.needs) or "nothing"


def _trained_in(card: PolicyCard, *, briefly: bool = False) -> str:
    """Return where a policy was trained; of a mixture all scenarios, or briefly the first and how many more."""
    named, others = with_parameters(card.scenario.name, card.scenario.parameters), card.training.mixture[1:]
    if others and briefly:
        named += f" and {len(others)} more"
    elif others:
        named = ", ".join([named, *(with_parameters(part.name, part.parameters) for part in others)])
    return named if card.scenario.team is None else f"{named}, as a team"


def _told(result: CardResult) -> str:
    each = result.individual_success
    robots = "" if each is None else f" of teams and {percent(each)} of robots"
    seeds = sorted(result.seeds.values())
    others = f"; all seeds {100 * seeds[0]:.1f} to {100 * seeds[-1]:.1f} %" if seeds else ""
    where = "" if result.scenario is None else f" of {result.scenario}"
    levels = with_parameters(f"{result.levels:,} {result.split} levels{where}", result.parameters)
    return f"{percent(result.success)} %{robots}, {levels}{others}; {result.source}"
