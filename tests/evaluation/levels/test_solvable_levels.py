"""Every level of every benchmark is solvable by its certificate, or refused by it.

A level is solvable where a reference policy of the certificate brings all robots to their goals within the time limit.
All others are refused: nothing proves that they can be solved, and evaluations say how many of them they have played.
What certificates say of a level must not contradict itself, and a replay must arrive as the certificate says.
"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from irsim_gym.evaluation.levels.certificate import Certificate, read_certificate
from irsim_gym.evaluation.levels.certificate_file import NUMBERS, rounded
from irsim_gym.evaluation.levels.played import PlayedLevels
from irsim_gym.evaluation.measures.metrics import OUTCOMES
from irsim_gym.evaluation.measures.optimum import heeds_goals
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.evaluation.saved_policies.policies import load_policy
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.specs.library import configs_folder
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.tasks import load_task

SHIPPED = sorted((configs_folder() / "certificates").glob("*.npz"))
HALF = {name: 0.5 * 10.0**-digits for name, digits in NUMBERS.items()}  # by so much are lengths and times rounded
REPLAYED = 12
SUCCESS = OUTCOMES.index("success")


def scenario_of(file: Path) -> Scenario:
    name, *given = file.stem.split("-")
    return load_scenario(name, dict(one.split("=") for one in given), warn=False)


@pytest.fixture(params=SHIPPED, ids=[file.stem for file in SHIPPED])
def file(request: pytest.FixtureRequest) -> Path:
    return request.param


def test_every_level_is_solvable_by_its_certificate_or_refused(file: Path) -> None:
    certificate = read_certificate(file)
    arrived = certificate.outcome == SUCCESS
    by_hand = np.array([any(policy[level].all() for policy in arrived) for level in range(certificate.count)])
    np.testing.assert_array_equal(certificate.solved, by_hand)
    played = PlayedLevels(certificate.count, certificate.set_hash, "", certificate)
    assert played.unsolved == certificate.count - by_hand.sum()
    assert len(set(certificate.hash.tolist())) == certificate.count, "a level is there twice"
    assert_the_runs_hold(certificate, scenario_of(file))
    if heeds_goals(load_task(scenario_of(file))):
        assert_the_ways_hold(certificate)
    else:
        assert_no_way_is_told(certificate)


def assert_the_ways_hold(certificate: Certificate) -> None:
    """A way that exists is no shorter than the straight one and leaves room; without one nothing is said."""
    there = certificate.reachable
    shape = certificate.count, len(certificate.agents)
    for name in ("reachable", "length", "straight", "clearance", "least_time"):
        assert getattr(certificate, name).shape == shape
    assert (certificate.length[there] >= certificate.straight[there] - 2 * HALF["length"]).all()
    assert (certificate.clearance[there] >= 0.0).all()
    assert (certificate.least_time[there] > 0.0).all()
    for name in ("length", "least_time"):
        np.testing.assert_array_equal(np.isfinite(getattr(certificate, name)), there)
    np.testing.assert_array_equal(np.isnan(certificate.clearance), ~there)
    assert (certificate.density >= 0.0).all()
    assert (certificate.density < 1.0).all()


def assert_no_way_is_told(certificate: Certificate) -> None:
    """Where nobody heeds goals of robots, a level is reachable if a policy solves it, and takes its time at most."""
    np.testing.assert_array_equal(certificate.reachable.all(axis=1), certificate.solved)
    np.testing.assert_array_equal(certificate.least_time, np.nan_to_num(certificate.time, nan=np.inf).min(axis=0))
    assert np.isinf(certificate.length).all()
    assert not certificate.straight.any()
    assert np.isnan(certificate.clearance).all()


def assert_the_runs_hold(certificate: Certificate, scenario: Scenario) -> None:
    """Runs end within the limit; who arrives has a way, and is not faster than any robot can be."""
    limit = load_task(scenario).max_steps * scenario.world.step_time
    shape = (len(certificate.policies), certificate.count, len(certificate.agents))
    assert certificate.outcome.shape == certificate.time.shape == shape
    assert certificate.outcome.max() < len(OUTCOMES)
    arrived = certificate.outcome == SUCCESS
    np.testing.assert_array_equal(np.isnan(certificate.time), ~arrived)
    assert (certificate.time[arrived] > 0.0).all()
    assert (certificate.time[arrived] <= limit + HALF["time"]).all()
    lengths = [body.shape for body in scenario.bodies if body.name in certificate.agents]
    if all(type(shape).__name__.startswith("Circle") for shape in lengths):
        assert certificate.reachable[arrived.any(axis=0)].all(), "a disc has arrived, but no way was found"
    least = np.broadcast_to(certificate.least_time, shape)
    known = arrived & np.isfinite(least)
    assert (certificate.time[known] >= least[known]).all()


@pytest.mark.slow
def test_who_solves_a_level_does_it_again(file: Path) -> None:
    """On levels from first to last, the fastest policy that solves a level arrives as the certificate says."""
    certificate, scenario = read_certificate(file), scenario_of(file)
    solved = np.flatnonzero(certificate.solved)
    if not solved.size:  # none of the one or two levels of some of JaxNav's worlds
        return
    chosen = solved[np.linspace(0, len(solved) - 1, min(REPLAYED, len(solved)), dtype=np.int64)]
    all_arrived = (certificate.outcome == SUCCESS).all(axis=2)
    times = np.where(all_arrived, certificate.time.max(axis=2), np.inf)
    by_solver = defaultdict(list)
    for level in chosen.tolist():
        by_solver[int(times[:, level].argmin())].append(level)
    episodes = make_episodes(scenario, n_worlds=len(chosen), team=len(certificate.agents) > 1)
    for k, levels in by_solver.items():
        rows = evaluate_team(load_policy(certificate.policies[k]), episodes, levels, certificate.split)
        assert all(row.is_success for row in rows), (certificate.policies[k], levels)
        found = rounded([[agent.episode.time for agent in row.agents] for row in rows], "time")
        np.testing.assert_array_equal(found, certificate.time[k, levels])
