"""The function ``irsim_gym.evaluation.robustness``: the same levels with stronger and stronger disturbances."""

import math
import secrets
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.outside_files import json_object, reading
from irsim_gym.base.version import __version__
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource
from irsim_gym.evaluation.comparison.comparison import sources_of
from irsim_gym.evaluation.comparison.evaluate import WORLDS, play, prepare
from irsim_gym.evaluation.curves.factors import Factor, chosen_factors, disturbed
from irsim_gym.evaluation.measures.metrics import Rate
from irsim_gym.evaluation.measures.optimum import Optima
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.policies.policy import Policy
from irsim_gym.evaluation.protocol.tables import (
    interval,
    markdown_table,
    number,
    percent,
    write_csv,
    write_json,
    write_text,
)
from irsim_gym.evaluation.requests.machine import machine
from irsim_gym.evaluation.requests.methods import Sources, by_method, names_of_policies
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import Source, policy_digest
from irsim_gym.evaluation.saved_policies.snapshot import snapshot_of
from irsim_gym.scenario.reading.parameters import PERTURBED
from irsim_gym.tasks import Episodes

RECORD = "robustness.json"
UNDISTURBED = Factor("undisturbed", "", (0.0,))
LOST = 5.0
"""The loss of success whose strength is looked for [%]."""
EVERY = "Success [%] with its 95 % interval; collisions [%]"
CURE = "Choose another folder with --out, or replace them with --overwrite"
COLUMNS = ("factor", "strength", "unit", "disturbances", "noise", "policy", "success", "low", "high", "collision")
LOW = 80.0
"""Undisturbed success below which a table says so, since a loss of 5 points means less there [%]."""


@dataclass(frozen=True)
class StrengthRow:
    """One policy with a disturbance of one strength.

    Attributes:
        factor: Name of the factor; ``undisturbed`` for a strength of 0.
        strength: Its strength [``unit``].
        unit: Unit of the strength.
        disturbances: The scenario's argument ``disturbances``.
        noise: Standard deviation of the noise that is added to each range [m].
        policy: Name of the policy.
        success: Share of the levels in which all learners arrived.
        collision: Share of the learners that collided.
    """

    factor: str
    strength: float
    unit: str
    disturbances: str
    noise: float
    policy: str
    success: Rate
    collision: Rate

    @property
    def label(self) -> str:
        """The factor with its strength."""
        return f"{self.factor} {self.strength:g} {self.unit}" if self.strength else self.factor


@dataclass(frozen=True)
class Robustness:
    """Success of policies over the strength of disturbances, on the same levels.

    Attributes:
        played: What rows in one folder have in common: scenario, its hash, split, number of levels, team and version;
            for each policy the hash of its file, for each factor its disturbances.
        rows: What was played.
        left_out: Factors that do not fit the robot, with the reason.
    """

    played: dict[str, Any]
    rows: list[StrengthRow] = field(default_factory=list)
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """The scenario and the levels."""
        return f"{self.played['scenario']}, {self.played['levels']:,} {self.played['split']} levels"

    @property
    def policies(self) -> list[str]:
        """Names of the policies."""
        return list(dict.fromkeys(row.policy for row in self.rows))

    @property
    def factors(self) -> dict[str, str]:
        """Units of the factors, by name."""
        return {row.factor: row.unit for row in self.rows if row.strength}

    def curve(self, factor: str, policy: str) -> list[StrengthRow]:
        """Return the rows of ``policy`` with ``factor`` by ascending strength, from the undisturbed one on."""
        rows = [row for row in self.rows if row.policy == policy and (row.factor == factor or not row.strength)]
        return sorted(rows, key=lambda row: row.strength)

    def lost_at(self, factor: str, policy: str) -> float:
        """Return the strength of ``factor``, in its unit, at which ``policy`` has lost 5 points of success.

        Between strengths that were played, success follows a straight line. Infinite if no strength costs as much; NaN
        if there are no 5 points to lose, or the policy has not played the factor.
        """
        points = [(row.strength, 100.0 * row.success.value) for row in self.curve(factor, policy)]
        least = points[0][1] - LOST if len(points) > 1 else math.nan
        for (weak, before), (strong, after) in pairwise(points if least >= 0.0 else ()):
            if after <= least:
                return weak + (before - least) / (before - after) * (strong - weak)
        return math.inf if least >= 0.0 else math.nan

    def __str__(self) -> str:
        """Return the tables as Markdown: where 5 points are lost, and the success with each strength."""
        rows = dict[str, list[str]]()
        for row in self.rows:
            cell = f"{percent(row.success)} ({interval(row.success)}); {percent(row.collision)}"
            rows.setdefault(row.label, ["-"] * len(self.policies))[self.policies.index(row.policy)] = cell
        lost = [
            [f"{factor} [{unit}]", *(self.lost_text(factor, policy) for policy in self.policies)]
            for factor, unit in self.factors.items()
        ]
        weak = [row for row in self.rows if not row.strength and 100.0 * row.success.value < LOW]
        notes = [f"Undisturbed success of {row.policy} is only {percent(row.success)} %." for row in weak]
        notes += [f"Without {name}: {reason}." for name, reason in self.left_out.items()]
        heads, title = ["disturbance", *self.policies], f"{self.title}: strength that costs {LOST:g} points of success"
        every = markdown_table(EVERY, [], heads, [[label, *cells] for label, cells in rows.items()])
        return f"{markdown_table(title, notes, heads, lost)}\n{every}"

    def lost_text(self, factor: str, policy: str) -> str:
        """Return ``lost_at`` of ``factor`` and ``policy`` for a table.

        It is ``0.24``, ``> 0.5`` beyond the strengths played, or ``-`` where it is NaN.
        """
        lost = self.lost_at(factor, policy)
        return f"> {self.curve(factor, policy)[-1].strength:g}" if math.isinf(lost) else number(lost, 2)

    def write(self, folder: Path) -> None:
        """Write ``robustness.json``, ``.csv`` and ``.md`` into ``folder``; in JSON, infinite numbers are null."""
        file = folder / RECORD
        lost = {
            name: {factor: at for factor in self.factors if not math.isnan(at := self.lost_at(factor, name))}
            for name in self.policies
        }
        write_json(file, {**asdict(self), "lost_5_points_at": lost, "machine": machine()})
        rows = [
            {**vars(row), **vars(row.success), "success": row.success.value, "collision": row.collision.value}
            for row in self.rows
        ]
        write_csv(file.with_suffix(".csv"), COLUMNS, rows)
        write_text(file.with_suffix(".md"), str(self))


def robustness(
    scenario: ScenarioSource,
    policies: Source | Sources,
    *,
    factors: Sequence[str] | None = None,
    levels: int = 500,
    split: str = "test",
    task: TaskSource = None,
    team: bool = False,
    folder: str | Path | None = None,
    overwrite: bool = False,
    parameters: Mapping[str, object] | None = None,
    strict: bool = True,
) -> Robustness:
    """Play the same levels with stronger and stronger disturbances of the learners; print the result for tables.

    Args:
        scenario: As for ``irsim_gym.evaluate``; so are ``policies``, ``split``, ``task``, ``team``, ``parameters``
            and ``strict``.
        factors: Names of factors or of kinds of disturbance; None for all that fit the robot.
        levels: Number of levels of the split, from 0.
        folder: Folder for rows, tables and a figure, which are not played again; None to write no files.
        overwrite: Replace the rows in the folder.

    Raises:
        ValueError: If ``levels`` is less than 1.
        IrsimGymError: If there is no such factor or policy, a policy does not fit the task, or the folder holds rows of
            another scenario, of other levels, or of another policy with the same name.
    """
    chosen, sources = chosen_factors(factors), sources_of(policies, levels)
    request, optima = ScenarioRequest(scenario, task, team, parameters, strict), Optima(split)
    loaded, _, worlds = prepare(request, sources, min(WORLDS, levels))
    base, place = worlds.episodes.simulation.scenario, None if folder is None else Path(folder)
    played = {"scenario": base.label, "sha256": snapshot_of(base, task).digest, "split": split, "levels": levels}
    played |= {"team": team, "version": __version__, **dict(_hashes(sources))}
    played |= {f"factor {factor.name}": f"{'; '.join(factor.perturb)}, noise {factor.noise:g}" for factor in chosen}
    record = _begun(played, place, overwrite)
    for factor, strength in ((item, strength) for item in (UNDISTURBED, *chosen) for strength in item.strengths):
        done = {row.policy for row in record.rows if (row.factor, row.strength) == (factor.name, strength)}
        missing = {name: policy for name, policy in loaded.items() if name not in done}
        if missing and factor.name not in record.left_out:
            _play(record, factor, strength, missing, request, worlds.episodes, optima)
            if place is not None:
                record.write(place)
    if place is not None and record.factors:
        _draw(record, place)
    return record


def _play(
    record: Robustness,
    factor: Factor,
    strength: float,
    policies: Mapping[str, Policy],
    request: ScenarioRequest,
    before: Episodes,
    optima: Optima,
) -> None:
    """Add the rows of policies with one strength of a factor, or say that the factor does not fit the robot.

    Args:
        request: The scenario with its task.
        before: Its undisturbed worlds.
    """
    base, of, noise = before.simulation.scenario, record.played, factor.noise * strength
    text = "; ".join(filter(None, (str(base.parameters.get(PERTURBED, "")), factor.text(strength))))
    try:
        scenario = disturbed(base, before.task.agents, text, noise)
        worlds = Perceived(replace(request, scenario=scenario, parameters=None).episodes(before.n_worlds))
    except IrsimGymError as problem:
        record.left_out[factor.name] = str(problem).splitlines()[-1].strip()
        return
    named = {f"{factor.name} {strength:g}, {name}": policy for name, policy in policies.items()}
    evaluation = play(named, {}, worlds, of["levels"], of["split"], team=of["team"], optima=optima)
    for name, summary in zip(policies, evaluation.summaries, strict=True):
        success = summary.cooperative_success if of["team"] else summary.success
        row = StrengthRow(factor.name, strength, factor.unit, text, noise, name, success, summary.collision)
        record.rows.append(row)
        print(f"{row.label}, {name}: {percent(success)} %", file=sys.stderr)


def _hashes(sources: Sources) -> Iterator[tuple[str, str]]:
    """Yield the names of policies and what tells them apart; of a function, a number that is never the same."""
    methods = by_method(sources)
    for method, names in names_of_policies(methods).items():
        for name, source in zip(names, methods[method], strict=True):
            digest = policy_digest(source) or str(source) if isinstance(source, str | Path) else secrets.token_hex()
            yield f"policy {name}", digest


def _begun(played: dict[str, Any], folder: Path | None, overwrite: bool) -> Robustness:
    """Return the record in a folder, or an empty one.

    Raises:
        IrsimGymError: If its rows cannot be compared with those to come, or it is no record.
    """
    if overwrite or folder is None or not (folder / RECORD).exists():
        return Robustness(played)
    with reading(folder / RECORD, "record of robustness"):
        before = TypeAdapter(Robustness).validate_python(json_object(folder / RECORD))
    pairs = {key: (before.played.get(key, now), now) for key, now in played.items()}
    changed = [f"{key} {old}, now {now}" for key, (old, now) in pairs.items() if old != now]
    if changed:
        raise IrsimGymError(f"{folder} holds rows of before a change: {'; '.join(changed)}. {CURE}")
    return Robustness({**before.played, **played}, before.rows)


def _draw(record: Robustness, folder: Path) -> None:
    """Draw a panel for each factor, with the curves of all policies."""
    from irsim_gym.rendering.figures.strengths_plot import Curve, draw_strengths

    panels = dict[str, dict[str, Curve]]()
    for factor, unit in record.factors.items():
        for name in record.policies:
            shares = [(row.strength, row.success) for row in record.curve(factor, name)]
            points = [(x, 100.0 * share.value, 100.0 * share.low, 100.0 * share.high) for x, share in shares]
            panels.setdefault(f"{factor} [{unit}]", {})[name] = points, record.lost_at(factor, name)
    draw_strengths([(folder / RECORD).with_suffix(end) for end in (".png", ".pdf")], panels, record.title)
