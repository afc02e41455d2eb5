"""The command ``irsim-gym export``: a policy with its contract, its driver and a check, in a folder for a robot."""

import hashlib
import io
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.families import FOOTPRINTS, KINEMATICS, SHIELDS
from irsim_gym.base.version import __version__
from irsim_gym.evaluation.measures.metrics import rate
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.policies.policy import Policy
from irsim_gym.evaluation.protocol.protocol import drive
from irsim_gym.evaluation.protocol.tables import write_bytes, write_json, write_text
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies import policies
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy
from irsim_gym.evaluation.saved_policies.shelf import ShelfPolicy
from irsim_gym.evaluation.saved_policies.snapshot import take_snapshot
from irsim_gym.robot import contract as forms
from irsim_gym.robot.contract import BodiesForm, Hashes, Results, RobotContract, ScenarioForm, ShieldForm, Stops
from irsim_gym.robot.graph_policy import ComparedPolicy, DelayedPolicy, GraphPolicy, without_latency
from irsim_gym.robot.inputs import (
    among_discs,
    is_disc,
    limits_of,
    scanner_form,
    seen_map_form,
    seers,
    sees_moving_only,
    tracker_of,
)
from irsim_gym.robot.model_card import model_card
from irsim_gym.robot.nodes.package import check_node, package_files
from irsim_gym.robot.parts.shield import AXES
from irsim_gym.robot.policy_graph import PolicyGraph, UnfitForRobotError, policy_graph
from irsim_gym.scenario.reading.parameters import PERTURBED, SHIELDED
from irsim_gym.simulator.engine import compile
from irsim_gym.simulator.world.model import ACKERMANN, STATE
from irsim_gym.tasks import Episodes, Outcome
from irsim_gym.tasks.episodes.prediction import steers
from irsim_gym.tasks.terms.term import NEEDS, needs_of
from irsim_gym.training.settings.run import run_of

LEVELS, SPLIT = 50, "test"
LONG_ENOUGH = 100
"""Steps of a level in which commands are compared, where its outcome does not count."""
TOLERANCE = 1e-5
"""Greatest difference of a command [m/s, rad/s or rad] between the package and the graph."""
PERIODS, LOST = 3.0, 0.3
ANY = {"bodies": ("n_bodies", 5)}
"""Shapes of inputs of any length, without the axis of the batch."""
SCRIPTS = {"drive.py": "", "scans.py": "", "parts/perceive.py": "seen_map", "parts/shield.py": "shield"}
"""Scripts that are copied beside the graph, and the field of a contract that asks for each."""
EXPORTED = ("policy.onnx", "contract.json", "contract.schema.json", "check.npz", "README.md")
FILES = (*EXPORTED, *(Path(place).name for place in SCRIPTS))


@dataclass(frozen=True)
class RobotExport:
    """A policy that has left.

    Attributes:
        contract: What it needs.
        n_commands: Number of commands in which it was compared.
        difference: How far they were apart at most.
        n_nodes: Number of nodes of the graph.
        folder: Where the files are.
    """

    contract: RobotContract
    n_commands: int
    difference: float
    n_nodes: int
    folder: Path


def export_for_robot(
    source: str,
    folder: Path,
    *,
    predict: float = 0.0,
    period: float | None = None,
    request: ScenarioRequest | None = None,
    levels: int = LEVELS,
    node: str | None = None,
    bodies: str | None = None,
    shield: str | None = None,
    lag: float = 0.0,
) -> RobotExport:
    """Write a policy as ONNX with its contract, driver, check and model card.

    Args:
        source: Name of a shipped policy, an exported file, a run's folder or a ``policy.zip`` in it.
        folder: Where to; it must not hold an export yet.
        predict: Time from a measurement until a new command acts [s], which the graph bridges; 0 for none.
        period: Time from one command to the next on the robot [s]; None for that of the training.
        request: The scenario with the robot and its scanner; None for that of the training.
        levels: Number of ``test`` levels that are played by both.
        node: ``ros1`` or ``ros2``: a package of it is written around the export; None for none.
        bodies: ``tracked``: the robot's own tracker gives other bodies as discs; None for policies without them.
        shield: What the driver's shield is, such as ``stop_in_time:margin=0.02``; None for that of the task, if any.
        lag: Time constant of the robot's drive, which the shield reckons with [s].

    Raises:
        IrsimGymError: The policy cannot leave, the folder holds an export, or the graph's commands differ from the
            policy's by more than 1e-5; nothing is written then.
    """
    _check_target(folder, node, bodies)
    loaded = load_policy(source)
    if not isinstance(loaded, SavedPolicy):
        raise IrsimGymError(f"'{source}' is no trained policy: behaviors plan in the simulator, and cannot leave")
    is_own, request = request is None, request or _trained_in(source, loaded)
    name, guard = policies.policy_names([source])[0], _shield_form(request, shield, predict, lag)
    played = _played(request, loaded, min(levels, LEVELS))
    loaded.check(played)
    network = _network(loaded)
    graph = policy_graph(network, played, name)
    discs = _among_discs(played, request, loaded, bodies)
    compared = ComparedPolicy(loaded, graph, loaded.perception)
    results = results_of(compared, discs, levels)
    _check_difference(compared, name)
    step = float(played.simulation.model.step_time[0])
    period, samples = period or step, compared.samples
    if predict > 0.0:
        graph = policy_graph(network, played, name, predict=predict, period=period)
        ahead = ComparedPolicy(GraphPolicy(graph), graph)
        results, samples = _late_results(ahead, round(predict / step), played, levels), ahead.samples
    elif discs is not played:
        results = results_of(GraphPolicy(graph), played, levels)
    contents, hashes = _sealed(graph, samples, scenario_hash(request), policies.policy_digest(source) or "")
    form = {"policy": name, "predict": predict, "results": results, **_form(played, graph, samples, period)}
    if is_own and discs is played and predict == 0.0:
        form |= _known_form(loaded)
    contract = RobotContract(hashes=hashes, scenario=_scenario_form(request), shield=guard, **form)
    _write(folder, contract, contents, played, node)
    return RobotExport(contract, compared.n_commands, compared.most, graph.n_nodes, folder)


def _check_target(folder: Path, node: str | None, bodies: str | None) -> None:
    check_node(node)
    if bodies not in (None, "tracked"):
        raise IrsimGymError(f"--bodies: there is no '{bodies}': write tracked")
    if bodies and node:
        raise IrsimGymError("--node: the nodes hear no tracker: leave it out, and call Driver.bodies in your own")
    present = [name for name in FILES if (folder / name).exists()]
    if present:
        raise IrsimGymError(f"--out: {folder} holds {present[0]} already: choose another folder, or remove it")


def _among_discs(played: Episodes, request: ScenarioRequest, policy: SavedPolicy, bodies: str | None) -> Episodes:
    """Return worlds in which a tracker gives all that the policy sees of others; often the same.

    Raises:
        UnfitForRobotError: It sees others, and there is no tracker.
    """
    seen, follows = [term.name for term in seers(played)], tracker_of(played) is not None
    if not seen and not follows:
        return played
    if bodies is None:
        what = f"observation '{seen[0]}' needs bodies ({NEEDS['bodies']})" if seen else "it observes tracks"
        raise UnfitForRobotError(f"{what}: add '--bodies tracked'")
    if seen and follows:
        raise UnfitForRobotError("it observes tracks and bodies that it is told: a driver takes one of them")
    if follows:
        return played
    loaded = request.load(warn=False)
    scenario = among_discs(loaded, played)
    if scenario is loaded:
        return played
    among = _played(replace(request, scenario=scenario, parameters=None), policy, played.n_worlds)
    among.limit(min(LONG_ENOUGH, among.task.max_steps))
    return among


def _played(request: ScenarioRequest, policy: SavedPolicy, n_worlds: int) -> Episodes:
    """Return worlds for a policy without disturbances from outside, predictions and shields: a robot has its own."""
    parameters = {name: value for name, value in (request.parameters or {}).items() if name != PERTURBED}
    played = Perceived(replace(request, parameters=parameters).episodes(n_worlds)).of(policy)
    own = replace(played.task, predict=False, shield=None)
    return played if own == played.task else Episodes(played.simulation, own)


def _shield_form(asked: ScenarioRequest, text: str | None, latency: float, lag: float) -> ShieldForm | None:
    """Return what a contract says of a shield; None without one.

    Raises:
        IrsimGymError: It cannot be used, or the driver does not know it or the robot's drive.
    """
    shielded = {SHIELDED: text} if text else {}
    played = replace(asked, parameters={**(asked.parameters or {}), **shielded}).episodes(1)
    options, b = played.task.shield, played.task.agents[0]
    if options is None:
        return None
    name, body = SHIELDS.name_of(type(options)), played.simulation.scenario.bodies[b]
    drive, shape = KINEMATICS.name_of(type(body.kinematics)), FOOTPRINTS.name_of(type(body.shape))
    if name != "stop_in_time" or drive not in AXES or not is_disc(played.simulation.model)[b]:
        known = f"stop_in_time for discs with the drive {', '.join(AXES)}"
        raise IrsimGymError(f"--shield: drivers know {known}; this is {name} for a {shape} with the drive {drive}")
    return ShieldForm(name="stop_in_time", margin=options.margin, latency=latency, lag=lag)


def _trained_in(source: str, policy: SavedPolicy) -> ScenarioRequest:
    """Return the scenario of a policy's training.

    Raises:
        IrsimGymError: It is not known.
    """
    card = policy.model.card if isinstance(policy.model, ShelfPolicy) else None
    if card is not None:
        scenario = card.scenario
        return ScenarioRequest(scenario.name, scenario.task, scenario.team is not None, scenario.parameters)
    run = run_of(policies.policy_file(source))
    if run.exists():
        return run.own_settings().request()
    raise IrsimGymError(f"the scenario of the training of {source} is not known: name it with --scenario")


def _known_form(policy: SavedPolicy) -> dict[str, Any]:
    """Return what a contract takes from a card: results in the own scenario, and the curves that hold for the graph."""
    card = policy.model.card if isinstance(policy.model, ShelfPolicy) else None
    if card is None or policy.perception is None:
        return {}
    late = ("latency", "all") if policy.perception.predict else ()  # the graph predicts by --predict alone
    known: dict[str, Any] = {"robustness": {name: one for name, one in card.robustness.items() if name not in late}}
    own = [one for one in card.results if one.scenario is None and one.parameters == card.scenario.parameters]
    if own:
        of, share = {"levels": own[0].levels, "split": own[0].split}, own[0].success
        known["results"] = Results(success=share.value, low=share.low, high=share.high, **of)
    return known


def _network(policy: SavedPolicy) -> ShelfPolicy:
    if isinstance(policy.model, ShelfPolicy):
        return policy.model
    from irsim_gym.training.export.exported_network import export_network

    network = export_network(policy.model, policy.normalization)
    return ShelfPolicy(network.form, network.arrays)


def results_of(policy: Policy, played: Episodes, levels: int) -> Results:
    """Return in how many levels all robots arrive."""
    solved = 0
    for _, worlds, _ in drive(policy, played, levels, SPLIT):
        solved += int((played.view.infos["outcome"][worlds] == Outcome.SUCCESS).all(axis=1).sum())
    share = rate(solved, levels)
    return Results(success=share.value, low=share.low, high=share.high, levels=levels, split=SPLIT)


def _late_results(policy: Policy, n_steps: int, played: Episodes, levels: int) -> Results:
    """Return the results of a policy whose commands act so many steps late, whatever latency the scenario has."""
    prompt = compile(without_latency(played.simulation.scenario), played.n_worlds, agents=played.task.agents)
    return results_of(DelayedPolicy(policy, n_steps), Episodes(prompt, played.task), levels)


def _check_difference(compared: ComparedPolicy, name: str) -> None:
    """Raise an IrsimGymError if the graph differs from the policy, or returned something that is not finite."""
    if not compared.most <= TOLERANCE:
        raise IrsimGymError(
            f"nothing is written: the graph of '{name}' differs by {compared.most:.3g} from the policy in "
            f"{compared.n_commands:,} commands, more than {TOLERANCE:g}"
        )


def _form(played: Episodes, graph: PolicyGraph, samples: Mapping[str, NDArray[Any]], period: float) -> dict[str, Any]:
    """Return what a contract says of the version, the robot, its scan, goal and times, and the tensors of the graph."""
    model, b, size = played.simulation.model, played.task.agents[0], int(played.action_sizes[0])
    drive, needs = played.simulation.scenario.bodies[b].kinematics, needs_of(played.task.observations)
    low, high = limits_of(played)
    age, rows = PERIODS * period, samples.get("bodies")
    most = 0 if rows is None else int(np.isfinite(rows).all(axis=2).sum(axis=1).max())
    limits = [None if np.isinf(limit) else float(limit) for limit in model.acceleration_limit[0, b, :size]]
    inputs = {
        name: forms.TensorForm(shape=("batch", *ANY.get(name, rows.shape[1:])), dtype=str(rows.dtype))
        for name, rows in samples.items()
        if name not in ("command", "level")
    }
    return {
        "irsim_gym": __version__,
        "period": period,
        "periods": (float(model.step_time[0]),) * 2,
        "stop": Stops(scan_age=age, odometry_age=age, bodies_age=age if "bodies" in inputs else None, lost_beams=LOST),
        "needs": needs,
        "scan": scanner_form(played) if "scan" in needs else None,
        "seen_map": seen_map_form(played),
        "bodies": None if rows is None else BodiesForm(source="tracked", most=most, moving=sees_moving_only(played)),
        "robot": forms.RobotLimits(
            drive=KINEMATICS.name_of(type(drive)),
            steers=steers(played.simulation, b),
            wheelbase=float(model.wheelbase[b]) if model.drive[b] == ACKERMANN else None,
            radius=float(model.reach[0, b]),
            radii=(float(model.reach[0, b]),) * 2,
            low=tuple(low.tolist()),
            high=tuple(high.tolist()),
            acceleration=tuple(limits),
        ),
        "goal": forms.GoalForm(
            frame="map" if "map_frame" in needs else "odom",
            heading=bool(model.arrive_mode[b] == STATE),
            tolerance=float(model.goal_threshold[0, b]),
        ),
        "inputs": inputs,
        "states": {
            name: forms.StateForm(shape=start.shape, dtype=str(start.dtype), start=_start(start))
            for name, start in graph.starts.items()
        },
        "outputs": {"command": tuple(f"{word} [{unit}]" for word, unit in played.terms["action"][0].components[0])},
    }


def _start(start: NDArray[Any]) -> Any:
    """Return what a state is at first: one number if all are the same; those that JSON lacks as text."""
    if start.size and np.array_equal(start, np.full_like(start, start.flat[0]), equal_nan=True):
        number = float(start.flat[0])
        return number if np.isfinite(number) else str(number)
    return start.tolist()


def scenario_hash(request: ScenarioRequest) -> str:
    """Return the hash of a scenario and its task."""
    form = _scenario_form(request)
    return take_snapshot(form.name, form.task, form.parameters).digest


def _scenario_form(request: ScenarioRequest) -> ScenarioForm:
    """Return how a contract names a scenario."""
    assert isinstance(request.scenario, str), "the command line, a card or a run names it"
    assert request.task is None or isinstance(request.task, str)
    return ScenarioForm(
        name=request.scenario, task=request.task, team=request.team, parameters=dict(request.parameters or {})
    )


def _sealed(
    graph: PolicyGraph, samples: Mapping[str, NDArray[Any]], scenario: str, policy: str
) -> tuple[dict[str, bytes], Hashes]:
    """Return policy.onnx, which holds the hashes of what it was made of, check.npz, and the hashes of all."""
    from onnx import helper, load_from_string

    model, check = load_from_string(graph.content), io.BytesIO()
    helper.set_model_props(model, {"scenario": scenario, "policy": policy})
    np.savez_compressed(check, **dict[str, Any](samples))
    contents = {"policy.onnx": bytes(model.SerializeToString()), "check.npz": check.getvalue()}
    onnx, npz = (hashlib.sha256(content).hexdigest() for content in contents.values())
    return contents, Hashes(scenario=scenario, policy=policy, onnx=onnx, check=npz)


def _write(
    folder: Path, contract: RobotContract, contents: Mapping[str, bytes], played: Episodes, node: str | None
) -> None:
    for name, content in contents.items():
        write_bytes(folder / name, content)
    for place, field in SCRIPTS.items():
        if not field or getattr(contract, field):
            write_bytes(folder / Path(place).name, (Path(__file__).parent / place).read_bytes())
    write_text(folder / "contract.json", contract.model_dump_json(indent=2, by_alias=True) + "\n")
    write_json(folder / "contract.schema.json", RobotContract.model_json_schema())
    write_text(folder / "README.md", model_card(contract, played.simulation.scenario.label))
    for place, text in package_files(contract, node).items() if node else ():
        write_text(folder / place, text)
