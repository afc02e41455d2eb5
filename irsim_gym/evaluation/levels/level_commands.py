"""The commands ``irsim-gym levels``: draw levels, and certify them."""

import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from irsim_gym.base.errors import IrsimGymError, report_together, several
from irsim_gym.evaluation.levels.certificate import Certificate, certificate_beside
from irsim_gym.evaluation.levels.certify import certify
from irsim_gym.evaluation.levels.draw import draw_levels
from irsim_gym.evaluation.measures.certificate_measures import is_disc
from irsim_gym.evaluation.measures.metrics import OUTCOMES
from irsim_gym.evaluation.measures.optimum import Optima
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.policies.policy import Policy
from irsim_gym.evaluation.policies.reference_policies import is_named_policy
from irsim_gym.evaluation.protocol.progress_bars import counting
from irsim_gym.evaluation.protocol.tables import write_bytes
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.requests.fitting import fitting_references
from irsim_gym.evaluation.requests.inputs import check_inputs
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import load_policy
from irsim_gym.scenario.specs.level_set import LevelSet, set_hash
from irsim_gym.simulator.world.model import ACKERMANN
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.episodes.levels import check_split

WORLDS = 64
REFERENCES = ("random", "dash", "orca", "dwa", "pursuit:known=seen", "pursuit")
"""Default reference policies: random, straight ahead, ORCA, local planning, paths on the seen and on the full map."""
POSES = "hybrid_astar"
"""Further reference policy for robots that are not discs or steer like a car: it plans over poses."""


def run_draw(request: ScenarioRequest, splits: Sequence[str], count: int, out: Path) -> LevelSet:
    """Draw ``count`` levels of each split, write them to a file, and return them."""
    check_inputs(request, partial(check_suffix, out), partial(_check_splits, splits))
    simulation = request.simulation(min(WORLDS, count))
    with counting("drawing", count * len(splits)) as advance:
        drawn = draw_levels(simulation, splits, count, advance)
    write_levels(drawn, out)
    return drawn


def _check_splits(splits: Sequence[str]) -> None:
    """Check that splits exist, and that none is named twice."""
    report_together(*(partial(check_split, split) for split in splits))
    if len(set(splits)) < len(splits):
        raise IrsimGymError(f"--split names a split twice: {','.join(splits)}")


def write_levels(levels: LevelSet, out: Path) -> None:
    """Write levels to a file, and print how many there are."""
    check_suffix(out)
    write_bytes(out, levels.content())
    split = "" if "all" in levels.splits else f" of {', '.join(levels.splits)}"
    print(f"{out}: {several(levels.count, 'level')}{split}, hash {set_hash(levels.hashes())}")


def run_certify(
    request: ScenarioRequest, split: str, count: int, policies: Sequence[str] | None, out: Path | None
) -> Certificate:
    """Certify levels, write the certificate, print a summary, and return the certificate.

    Args:
        count: Number of levels.
        policies: Reference policies, as ``load_policy`` takes them; None for all default ones that fit the agents.
        out: File to write; None for one beside the scenario's file. For a shipped scenario, it is in the current
            folder.
    """
    check_inputs(request, lambda: None if out is None else check_suffix(out), policies=policies or (), split=split)
    episodes = request.episodes(min(WORLDS, count))
    cert = _certified(episodes, split, count, policies)
    file = Path(str(request.scenario))
    path = out or certificate_beside(file if file.is_file() else Path(episodes.simulation.scenario.name))
    for line in _summary(cert):
        print(line)
    write_bytes(path, cert.content())
    print(f"{path}: {several(cert.count, 'level')} of {cert.split}, hash {cert.set_hash}")
    return cert


def _certified(episodes: Episodes, split: str, count: int, policies: Sequence[str] | None) -> Certificate:
    """Return the certificate of levels, and show a progress bar; see ``run_certify``."""
    chosen = _fitting(episodes) if policies is None else {name: load_policy(name) for name in policies}
    optima, worlds = Optima(split), Perceived(episodes)
    with counting("certifying", count * (1 + len(chosen))) as advance:
        rows = {
            name: evaluate_team(policy, worlds.of(policy), count, split, optima=optima, on_episodes=advance)
            for name, policy in chosen.items()
        }
        return certify(episodes, split, count, rows, advance)


def _fitting(episodes: Episodes) -> dict[str, Policy]:
    """Return the default reference policies that are available and can drive the agents."""
    model, agents = episodes.simulation.model, episodes.simulation.agents.tolist()
    needs_poses = any(model.drive[body] == ACKERMANN or not is_disc(model, body) for body in agents)
    names = filter(is_named_policy, (*REFERENCES, POSES) if needs_poses else REFERENCES)
    return fitting_references(names, episodes, sys.stdout)


def _summary(cert: Certificate) -> Iterator[str]:
    """Yield lines that summarise the certificate of all levels."""
    yield f"{cert.name}: {100.0 * cert.reachable.all(axis=1).mean():.1f} % of {cert.count:,} levels are reachable"
    for name in ("length", "clearance", "least_time"):
        values = getattr(cert, name)
        if np.isfinite(values).any():
            low, middle, high = np.nanpercentile(values, (5, 50, 95))
            yield f"  {name:<10} {low:.2f} / {middle:.2f} / {high:.2f}  (5 %, median, 95 %)"
    for policy, outcome in zip(cert.policies, cert.outcome, strict=True):
        yield f"  {policy:<10} succeeds in {100.0 * (outcome == OUTCOMES.index('success')).mean():.1f} %"


def check_suffix(out: Path) -> None:
    """Check that the name of a file of levels ends in ``.npz``.

    Raises:
        IrsimGymError: If it does not.
    """
    if out.suffix != ".npz":
        raise IrsimGymError(f"a file of levels ends in .npz, got '{out.name}'")
