"""Policy cards: a policy's inputs and outputs, its training, and its results."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from irsim_gym.base.outside_files import json_object, reading
from irsim_gym.scenario.reading.parameters import PERTURBED

CURVES = "robustness"
"""Folder beside policies with records of ``irsim-gym robustness``, which cards are completed with."""


class _Fixed(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class CardShare(_Fixed):
    """A share of levels or robots, with its 95 % Wilson score interval.

    Attributes:
        count: Number of counted levels or robots.
        value: Their share of all.
        low: Lower end of the interval, a share.
        high: Upper end of the interval, a share.
    """

    count: int
    value: float
    low: float
    high: float


class CardScenario(_Fixed):
    """The scenario that a policy was trained in.

    Attributes:
        name: Name of the scenario.
        parameters: Values of its parameters.
        task: Name of the task; None for the scenario's own.
        team: Team mode of the training, ``"episode"`` or ``"respawn"``; None for a single learner.
        sha256: Hash of the contents of the scenario and its task, without image files.
    """

    name: str
    parameters: dict[str, Any]
    task: str | None
    team: str | None
    sha256: str


class CardTerm(_Fixed):
    """A term of the observation.

    Attributes:
        name: Name of the term in the task.
        shape: Shape of its numbers.
    """

    name: str
    shape: tuple[int, ...]


class CardAction(_Fixed):
    """The action of a policy.

    Attributes:
        name: Kind of the action.
        components: Names of its components.
        choices: Number of choices; None for a continuous action.
    """

    name: str
    components: tuple[str, ...]
    choices: int | None


class CardNetwork(_Fixed):
    """The network of a policy.

    Attributes:
        layers: Description of each layer.
        weights: Number of weights.
    """

    layers: tuple[str, ...]
    weights: int


class CardPart(_Fixed):
    """One scenario of a mixture.

    Attributes:
        name: Name of the scenario.
        parameters: Values of its parameters.
        share: Its share of the worlds.
    """

    name: str
    parameters: dict[str, Any]
    share: float


class CardTraining(_Fixed):
    """How a policy was trained, and at what cost.

    Attributes:
        algorithm: Name of the algorithm.
        hyperparameters: Hyper-parameters of the training.
        seed: Seed of this policy.
        seeds: Seeds that were trained in the same way, including this one.
        steps: Number of training steps.
        training_seconds: Wall-clock time of training alone [s].
        cpu_seconds: Processor time of training alone [s].
        machine: Machine, and versions of packages.
        mixture: All scenarios of a mixture, that of the card first; empty for a single scenario.
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
    """Results of a policy on the levels of a split.

    Attributes:
        split: ``"test"``, ``"dev"`` or ``"train"``.
        levels: Number of levels, from 0.
        level_hash: Hash of these levels; None if the source does not record it.
        parameters: Values of the scenario's parameters.
        team: Whether the figures are those of whole teams.
        success: Share of solved levels; for a team, of levels that all robots solve.
        individual_success: Share of robots that reach their goals; None for a single robot.
        collision: Share of robots that collide.
        timeout: Share of robots that run out of time.
        spl: Success weighted by path length, a share.
        seeds: Share of solved levels of each training seed on the same levels, by run.
        source: File or table that the figures come from.
        scenario: Scenario of the levels; None for the scenario of the card.
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


class CardCurve(_Fixed):
    """The strength of a disturbance that costs 5 points of success in the scenario of the training."""

    model_config = ConfigDict(populate_by_name=True)

    unit: str = Field(description="Unit of the strengths.")
    lost_at: float | None = Field(alias="5 points lost at", description="None if all strengths cost less.")
    played_to: float = Field(description="Greatest strength that was played.")
    levels: int = Field(description="Number of levels.")
    split: str

    def __str__(self) -> str:
        return f"{f'> {self.played_to:g}' if self.lost_at is None else f'{self.lost_at:.2g}'} {self.unit}"


class PolicyCard(_Fixed):
    """Description of a shipped policy.

    Attributes:
        name: Name of the policy.
        scenario: The scenario that it was trained in.
        observation: Terms of its observation, in order.
        needs: What a robot must have to observe that, see ``tasks.terms.term.NEEDS``; None where a plugin does not say.
        action: Its action.
        network: Its network.
        training: How it was trained, and at what cost.
        results: Its results.
        weaknesses: Known weaknesses, in sentences.
        sha256: Hash of the file.
        size: Size of the file [bytes].
        exported_by: Version of irsim_gym that wrote the file.
        robustness: Its curves by factor, from the records in the folder ``robustness`` beside it.
    """

    name: str
    scenario: CardScenario
    observation: tuple[CardTerm, ...]
    needs: tuple[str, ...] | None = None
    action: CardAction
    network: CardNetwork
    training: CardTraining
    results: tuple[CardResult, ...]
    weaknesses: tuple[str, ...]
    sha256: str
    size: int
    exported_by: str
    robustness: dict[str, CardCurve] = {}


def card_file(policy: Path) -> Path:
    """Return the path of the card of a policy file, in the same folder."""
    return policy.with_suffix(".json")


def read_card(policy: Path) -> PolicyCard | None:
    """Return the card of a policy file; None if it has none.

    Raises:
        IrsimGymError: If the file is not a valid card, or a record beside it is broken.
    """
    file = card_file(policy)
    if not file.is_file():
        return None
    with reading(file, "policy card"):
        card = PolicyCard.model_validate_json(file.read_bytes())
    curves = dict[str, CardCurve]()
    for record in sorted((policy.parent / CURVES).glob("*.json")):
        with reading(record, "record of robustness"):
            curves |= _curves(json_object(record), card)
    return card.model_copy(update={"robustness": curves}) if curves else card


def _curves(record: Mapping[str, Any], card: PolicyCard) -> dict[str, CardCurve]:
    """Return the curves that a record has of a policy, in the undisturbed scenario of its training."""
    played, curves = record["played"], dict[str, CardCurve]()
    name, _, parameters = played["scenario"].partition(" (")
    if name != card.scenario.name or PERTURBED in parameters:
        return curves
    for row in record["rows"]:
        lost, factor = record["lost_5_points_at"][row["policy"]], row["factor"]
        if played[f"policy {row['policy']}"] == card.sha256 and factor in lost:
            conditions = {"levels": played["levels"], "split": played["split"], "played_to": row["strength"]}
            curves[factor] = CardCurve(unit=row["unit"], lost_at=lost[factor], **conditions)
    return curves
