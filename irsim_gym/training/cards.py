"""Cards of policies: what a policy does, where it comes from, and how good it is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from irsim_gym.errors import IrsimGymError


class _Fixed(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class CardShare(_Fixed):
    """A share of levels or robots, with its 95 % Wilson interval."""

    count: int
    value: float
    low: float
    high: float


class CardScenario(_Fixed):
    """Where a policy was trained.

    Attributes:
        name: The scenario.
        parameters: Values of its parameters.
        task: The task; None for the scenario's own.
        team: What robots that had ended did while others learned on; None where one robot learned.
        sha256: Hash of all that the scenario and its task say, but for pictures.
    """

    name: str
    parameters: dict[str, Any]
    task: str | None
    team: str | None
    sha256: str


class CardTerm(_Fixed):
    """A part of an observation: its name in the task, and the shape of its numbers."""

    name: str
    shape: tuple[int, ...]


class CardAction(_Fixed):
    """What a policy gives: the kind of the action, its components, and the number of its choices where it has some."""

    name: str
    components: tuple[str, ...]
    choices: int | None


class CardNetwork(_Fixed):
    """What computes the action: layers in words, and how many weights they have."""

    layers: tuple[str, ...]
    weights: int


class CardPart(_Fixed):
    """One scenario of a mixture: its name, values of its parameters, and its weight among all."""

    name: str
    parameters: dict[str, Any]
    share: float


class CardTraining(_Fixed):
    """How a policy was trained, and at what cost.

    Attributes:
        algorithm: The algorithm.
        hyperparameters: Its settings.
        seed: Seed of this policy.
        seeds: Seeds that were trained alike, this one among them.
        steps: Training steps.
        training_seconds: Wall-clock time [s], of learning alone.
        cpu_seconds: Processor time [s], likewise.
        machine: Machine and versions.
        mixture: All scenarios that were learnt together, that of the card first; empty for one alone.
    """

    algorithm: str
    hyperparameters: dict[str, Any]
    seed: int
    seeds: tuple[int, ...]
    steps: int
    training_seconds: float
    cpu_seconds: float
    machine: dict[str, Any]
    mixture: tuple[CardPart, ...] = ()


class CardResult(_Fixed):
    """How good a policy is on some levels.

    Attributes:
        split: ``"test"``, ``"dev"`` or ``"train"``.
        levels: How many levels of it, from 0.
        level_hash: Hash of what was drawn for them; None where the source does not have it.
        parameters: Values of the scenario's parameters.
        team: The figures are those of whole teams.
        success: CardShare of levels that it solves; of a team, with all robots.
        individual_success: CardShare of robots that arrive; None for one robot.
        collision: CardShare of robots that collide.
        timeout: CardShare of robots that run out of time.
        spl: Success weighted by path length.
        seeds: Success of each seed of the training on the same levels, by run.
        source: Where the figures are from.
        scenario: Where it plays; None for the card's own scenario.
    """

    split: str
    levels: int
    level_hash: str | None
    parameters: dict[str, Any]
    team: bool
    success: CardShare
    individual_success: CardShare | None
    collision: float
    timeout: float
    spl: float
    seeds: dict[str, float]
    source: str
    scenario: str | None = None


class PolicyCard(_Fixed):
    """What is known of a policy.

    Attributes:
        name: Name on the shelf.
        scenario: Where it was trained.
        observation: Parts of its observation, in order.
        action: What it gives.
        network: What computes it.
        training: How it was trained.
        results: How good it is.
        weaknesses: What it does badly, in sentences.
        sha256: Hash of its file.
        size: Of its file [bytes].
        exported_by: Version of irsim_gym that wrote the file.
    """

    name: str
    scenario: CardScenario
    observation: tuple[CardTerm, ...]
    action: CardAction
    network: CardNetwork
    training: CardTraining
    results: tuple[CardResult, ...]
    weaknesses: tuple[str, ...]
    sha256: str
    size: int
    exported_by: str


def card_file(policy: Path) -> Path:
    """Return where the card of a policy's file is: beside it."""
    return policy.with_suffix(".json")


def read_card(policy: Path) -> PolicyCard | None:
    """Return the card of a policy's file; None where it has none.

    Raises:
        IrsimGymError: It is no card.
    """
    file = card_file(policy)
    if not file.is_file():
        return None
    try:
        return PolicyCard.model_validate_json(file.read_bytes())
    except ValidationError as error:
        told = "; ".join(f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors())
        raise IrsimGymError(f"{file} is no card of a policy: {told}") from error
