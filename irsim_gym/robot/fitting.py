"""The command ``irsim-gym fit``: which other scanners, mounts, periods and sizes an exported policy may have."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from irsim_gym.base.errors import IrsimGymError, suggestion
from irsim_gym.base.families import FOOTPRINTS, KINEMATICS
from irsim_gym.evaluation.policies.policy import Policy
from irsim_gym.evaluation.protocol.tables import write_text
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.robot.contract import Results, RobotContract, Tested, read_export
from irsim_gym.robot.export import SPLIT, results_of, scenario_hash
from irsim_gym.robot.graph_policy import DelayedPolicy, GraphPolicy, without_latency
from irsim_gym.robot.inputs import Measured, limits_of, measured, scanner_of
from irsim_gym.robot.policy_graph import PolicyGraph
from irsim_gym.robot.scans import as_beams
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs.library import find
from irsim_gym.scenario.specs.spec import BodySpec, Scenario
from irsim_gym.scenario.text.expressions import evaluate
from irsim_gym.tasks import Episodes

LEVELS = 200
MOST_LOST = 0.02
"""Greatest share of levels that another robot may solve less."""
UNPLAYED = Results(success=0.0, low=0.0, high=1.0, levels=0, split=SPLIT)
SCANNER = {"beams": "beams", "range": "range_max", "fov": "field_of_view"}
MOUNT = {"x": "x", "y": "y", "turn": "turn"}
Values = Mapping[str, float]
"""What a robot differs in, by name: beams, range_max [m], field_of_view [rad], x, y [m], turn [rad], period [s],
radius [m]."""


@dataclass(frozen=True)
class Variant:
    """A robot, and how the policy does on it.

    Attributes:
        name: What it differs in.
        values: All of its values.
        body: A robot whose drive, limits and footprint it has; None for those of the training.
        results: The policy's.
        fits: Whether it loses at most 2 points.
    """

    name: str
    values: Values
    body: BodySpec | None = None
    results: Results = UNPLAYED
    fits: bool = False

    @property
    def cells(self) -> tuple[str, str, str]:
        """What it differs in, the success with its interval [%], and whether it fits."""
        success, low, high = (100.0 * share for share in (self.results.success, self.results.low, self.results.high))
        return self.name, f"{success:.1f} [{low:.1f}, {high:.1f}]", "yes" if self.fits else "no"


def fit(folder: Path, variants: Sequence[Variant], levels: int = LEVELS) -> list[Variant]:
    """Play an exported policy with other robots, and widen the tested values in its contract.

    Args:
        folder: The export.
        variants: The robots, with the values in which each differs; none for those of ``usual``.
        levels: Number of ``test`` levels.

    Returns:
        The robots with their results, that of the contract first.

    Raises:
        IrsimGymError: The export is broken, its scenario has changed, or a robot cannot have it.
    """
    contract, content = read_export(folder)
    form = contract.scenario
    asked = ScenarioRequest(form.name, form.task, form.team, form.parameters)
    if scenario_hash(asked) != contract.hashes.scenario:
        raise IrsimGymError(f"{form.name} has changed since {folder} was written: export the policy again")
    own = own_values(contract)
    _check(contract, own, variants)
    graph = PolicyGraph(content, _starts(contract), 0, contract.model_dump() if contract.seen_map else None)
    played: list[Variant] = []
    for variant in (Variant("as in the contract", {}), *(variants or usual(own))):
        one = _played(contract, graph, asked, replace(variant, values={**own, **variant.values}), levels)
        least = played[0].results.success - MOST_LOST if played else 0.0
        played.append(replace(one, fits=one.results.success >= least - 1e-9))
    write_text(folder / "contract.json", widened(contract, played).model_dump_json(indent=2, by_alias=True) + "\n")
    return played


def own_values(contract: RobotContract) -> dict[str, float]:
    """Return the values of the robot that a policy was exported for."""
    scan, others = contract.scan, {"period": contract.period, "radius": contract.robot.radius}
    if scan is None:
        return others
    mount = dict(zip(MOUNT, scan.mount, strict=True))
    view = scan.step * (scan.beams - 1)
    return {"beams": scan.beams, "range_max": scan.range_max, "field_of_view": view, **mount, **others}


def usual(own: Values) -> list[Variant]:
    """Return robots to play with if none are named: what scanners differ in, one by one and together."""
    scanners = [{"beams": 90}, {"beams": 360}, {"range_max": 3.5}, {"range_max": 12.0}]
    scanners += [{"field_of_view": 1.5 * np.pi}, {"beams": 90, "range_max": 3.5, "field_of_view": 1.5 * np.pi}]
    periods = [{"period": factor * own["period"]} for factor in (0.5, 2.0)]
    return [Variant(told(values), values) for values in (*(scanners if "beams" in own else ()), *periods)]


def told(values: Values) -> str:
    """Return values for people: ``field_of_view 270 deg``."""
    return ", ".join(
        f"{name} {np.degrees(value):.4g} deg" if name in ("field_of_view", "turn") else f"{name} {value:.4g}"
        for name, value in values.items()
    )


def read_values(option: str, text: str, names: Mapping[str, str]) -> dict[str, float]:
    """Return what an option such as ``--scanner beams=360,range=3.5,fov=270deg`` says.

    Args:
        names: Names of the values by their words.

    Raises:
        IrsimGymError: It is not of this form.
    """
    values = {}
    for part in text.split(","):
        word, _, number = (piece.strip() for piece in part.partition("="))
        found = evaluate(number.removesuffix("deg"))
        if word not in names or found is None or (names is SCANNER and found <= 0):
            near = suggestion(word, names) if word not in names else ""
            form = f"{option}: write numbers for {', '.join(names)}, such as {next(iter(names))}=..., with commas"
            raise IrsimGymError(f"{form}{', above 0' if names is SCANNER else ''}; got '{part}'{near}")
        values[names[word]] = float(np.radians(found)) if number.endswith("deg") else found
    return values


def preset_variant(name: str) -> Variant:
    """Return a robot that is shipped as a preset.

    Raises:
        IrsimGymError: There is none of this name; the message lists them.
    """
    loaded = load_scenario(find(name, "robots"))
    body, values = loaded.bodies[0], {"period": loaded.world.step_time}
    for options in body.sensors[:1]:
        values |= dict(zip(MOUNT, options.offset, strict=True))
        values |= {"beams": options.number, "range_max": options.range_max, "field_of_view": options.angle_range}
    return Variant(name, values, body)


def _check(contract: RobotContract, own: Values, variants: Iterable[Variant]) -> None:
    """Raise an IrsimGymError for robots that the policy cannot drive, or values that it does not have."""
    for variant in variants:
        lacking = [] if variant.body is not None else [name for name in variant.values if name not in own]
        if lacking:
            raise IrsimGymError(f"{contract.policy} has no scanner: it has no {lacking[0]}")
        if contract.predict and variant.values.get("period", contract.period) != contract.period:
            raise IrsimGymError(f"the predictor is made for a period of {contract.period:g} s: export with --period")
        drive = contract.robot.drive if variant.body is None else KINEMATICS.name_of(type(variant.body.kinematics))
        if drive != contract.robot.drive:
            raise IrsimGymError(f"{contract.policy} drives '{contract.robot.drive}', {variant.name} is '{drive}'")


def _starts(contract: RobotContract) -> dict[str, Any]:
    """Return what each state of a graph is before the first step."""
    return {
        name: np.broadcast_to(np.array(form.start, float).astype(form.dtype), form.shape)
        for name, form in contract.states.items()
    }


def _played(
    contract: RobotContract, graph: PolicyGraph, asked: ScenarioRequest, variant: Variant, levels: int
) -> Variant:
    """Return another robot with the results of the policy, which drives it as the driver does."""
    before = asked.episodes(1)
    step, period = float(before.simulation.model.step_time[0]), variant.values["period"]
    loaded = asked.load(warn=False)
    scenario = _changed(without_latency(loaded) if contract.predict else loaded, before, variant)
    played = replace(asked, scenario=scenario, parameters=None).episodes(levels)
    if variant.body is not None and played.n_discrete:
        raise IrsimGymError(f"{contract.policy} chooses between commands: only those of its own robot are known")
    limits = np.array(contract.robot.low), np.array(contract.robot.high)
    slower = max(1.0, float(limits[1][0] / limits_of(played)[1][0]))  # a slow robot gets as much more time
    played.limit(max(1, round(before.task.max_steps * slower * step / period)))
    policy: Policy = GraphPolicy(
        graph, measure=partial(_measured, contract), limits=None if variant.body is None else limits
    )
    if contract.predict:
        policy = DelayedPolicy(policy, round(contract.predict / period))
    radius = float(played.simulation.model.reach[0, played.task.agents[0]])
    return replace(variant, values={**variant.values, "radius": radius}, results=results_of(policy, played, levels))


def _changed(scenario: Scenario, before: Episodes, variant: Variant) -> Scenario:
    """Return a scenario whose agents are another robot."""
    values, scanner, bodies = variant.values, scanner_of(before), list(scenario.bodies)
    same_size = values["radius"] == float(before.simulation.model.reach[0, before.task.agents[0]])
    for agent in before.task.agents:
        body, other = bodies[agent], variant.body
        changes: dict[str, Any] = {}
        if other is not None:
            changes = {name: getattr(other, name) for name in ("shape", "vel_min", "vel_max", "acce")}
        elif not same_size:
            if FOOTPRINTS.name_of(type(body.shape)) != "circle":
                raise IrsimGymError(f"{body.name} is no disc: it has no radius to change")
            changes["shape"] = replace(body.shape, radius=values["radius"])
        if scanner is not None:
            changes["sensors"] = tuple(_scanner(one, values) if one == scanner[0] else one for one in body.sensors)
        bodies[agent] = replace(body, **changes)
    world = scenario.world
    if values["period"] > world.step_time:
        world = replace(world, collision_check="swept")
    return replace(scenario, bodies=tuple(bodies), world=replace(world, step_time=values["period"]))


def _scanner(options: Any, values: Values) -> Any:
    return replace(
        options,
        number=round(values["beams"]),
        angle_range=values["field_of_view"],
        range_max=values["range_max"],
        range_min=min(options.range_min, values["range_max"]),
        offset=tuple(values[name] for name in MOUNT),
    )


def _measured(contract: RobotContract, episodes: Episodes, agent: int) -> Measured:
    """Return what a robot measures, its scan by the beams of the contract."""
    values, scanner = measured(episodes, agent), scanner_of(episodes, agent)
    if scanner is None or contract.scan is None:
        return values
    options, _, angles = scanner
    ranges = np.where(values["ranges"] < options.range_max, values["ranges"], np.inf)
    step = float(angles[1] - angles[0]) if len(angles) > 1 else 0.0
    return {**values, "ranges": as_beams(ranges, (angles[0], step), options.offset, contract.scan.model_dump())}


def widened(contract: RobotContract, played: Iterable[Variant]) -> RobotContract:
    """Return a contract whose tested values include those of robots that fit, and of none that does not fit."""
    scan, spans = contract.scan, {"period": contract.periods, "radius": contract.robot.radii}
    if scan is not None:
        spans |= {**scan.tested.model_dump(), **dict(zip(MOUNT, scan.mounts, strict=True))}
    misfits = [variant.values for variant in played if not variant.fits]
    for variant in played:
        wider = {
            name: (min(low, variant.values[name]), max(high, variant.values[name]))
            for name, (low, high) in spans.items()
        }
        if variant.fits and not any(_holds(wider, values) for values in misfits):
            spans = wider
    if scan is not None:
        tested = Tested(**{name: spans[name] for name in Tested.model_fields})
        scan = scan.model_copy(update={"tested": tested, "mounts": tuple(spans[name] for name in MOUNT)})
    robot = contract.robot.model_copy(update={"radii": spans["radius"]})
    return contract.model_copy(update={"scan": scan, "robot": robot, "periods": spans["period"]})


def _holds(spans: Mapping[str, tuple[float, float]], values: Values) -> bool:
    return all(low <= values[name] <= high for name, (low, high) in spans.items())
