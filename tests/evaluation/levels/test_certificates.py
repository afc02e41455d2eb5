"""Certificates against an independent search, SciPy's on a grid over shapely's shapes; shipped ones against levels."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

import irsim_gym as ig
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.levels.certificate import Certificate, find_certificate, read_certificate, shipped_certificate
from irsim_gym.evaluation.levels.certificate_file import NUMBERS, WHOLE, rounded
from irsim_gym.evaluation.levels.certify import certify
from irsim_gym.evaluation.levels.draw import draw_levels
from irsim_gym.evaluation.policies.reference_policies import reference_policy
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.evaluation.suite.members import shipped_suite
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.specs.level_set import set_hash
from irsim_gym.scenario.specs.library import configs_folder
from irsim_gym.simulator.world.outline import outline_rows

SPACING = 0.05
MOVES = [(1, 0), (0, 1), (1, 1), (1, -1), (1, 2), (2, 1), (1, -2), (2, -1)]
STRETCH = 1.028  # of a way along 16 directions: 1 / cos(13.3 degrees), half of the widest angle between two of them
LINKS = 1.03  # certified ways are up to so much longer than the shortest
GAP = 0.03  # [m]; ways through gaps that are hardly wider than the disc may be missed
PUSHING = "push_box", "clear_doorway", "sort_boxes", "ice_channel"
SHIPPED = sorted((configs_folder() / "certificates").glob("*.npz"))


def search(simulation: ig.Simulation, world: int, body: int) -> tuple[float, float, float, float]:
    """Return on a grid of 0.05 m the lengths of the shortest ways of a disc that is 0.03 m smaller and one that is as
    much larger, the least clearance on the widest way, and the density.
    """
    model, state = simulation.model, simulation.state
    areas: list[Any] = []
    lines: list[Any] = []
    for b in np.flatnonzero(model.present[world] & model.stands & ~model.unobstructed):
        segments, discs = outline_rows(model, state, world, int(b))
        if len(segments) and model.solid[b]:
            areas.append(shapely.Polygon(segments[:, :2]))
        elif len(segments):
            lines.append(shapely.LineString(np.vstack([segments[:, :2], segments[-1:, 2:]])))
        areas += [shapely.Point(x, y).buffer(r, quad_segs=64) for x, y, r in discs]
    standing = shapely.union_all([*areas, *lines])
    x0, y0, x1, y1 = model.bounds
    columns, rows = round((x1 - x0) / SPACING) + 1, round((y1 - y0) / SPACING) + 1
    x, y = np.meshgrid(x0 + SPACING * np.arange(columns), y0 + SPACING * np.arange(rows), indexing="ij")
    room = shapely.distance(standing, shapely.points(x.ravel(), y.ravel())) - model.reach[0, body]
    ends = [
        int(round((px - x0) / SPACING) * rows + round((py - y0) / SPACING))
        for px, py in (state.pose[world, body, :2], state.goal[world, body, :2])
    ]
    number, graph = np.arange(columns * rows).reshape(columns, rows), []
    for dx, dy in MOVES:
        one = number[: columns - dx, max(-dy, 0) : rows - max(dy, 0)].ravel()
        graph.append((one, one + dx * rows + dy, np.full(len(one), SPACING * np.hypot(dx, dy))))
    tails, heads, lengths = (np.concatenate(part) for part in zip(*graph, strict=True))

    def allowed(least: float) -> coo_array:
        free = (room[tails] > least) & (room[heads] > least)
        return coo_array((lengths[free], (tails[free], heads[free])), shape=(len(room), len(room)))

    lengths_found = [dijkstra(allowed(gap), directed=False, indices=ends[0])[ends[1]] for gap in (-GAP, GAP)]
    low, high = 0.0, float(room.max())
    for _ in range(12):
        middle = (low + high) / 2
        labels = connected_components(allowed(middle), directed=False)[1]
        low, high = (middle, high) if labels[ends[0]] == labels[ends[1]] else (low, middle)
    covered = shapely.contains_xy(shapely.union_all(areas), x.ravel(), y.ravel()).mean()
    return float(lengths_found[0]), float(lengths_found[1]), low, float(covered)


def assert_certified(name: str, count: int) -> None:
    episodes = make_episodes(name, n_worlds=count)
    made = certify(episodes, "test", count, {})
    episodes.simulation.reset(0, "test")
    for level in range(count):
        short, long, clearance, covered = search(episodes.simulation, level, int(episodes.simulation.agents[0]))
        assert np.isfinite(short) >= made.reachable[level, 0] >= np.isfinite(long)
        assert short / STRETCH - 2 * SPACING < made.length[level, 0] <= LINKS * long + 2 * SPACING, level
        assert made.clearance[level, 0] == pytest.approx(clearance, abs=1.5 * SPACING), level
        assert made.density[level] == pytest.approx(covered, abs=0.01), level


def test_certificates_agree_with_another_search() -> None:
    assert_certified("cluttered_room", 3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cluttered_room", "dense_room"])
def test_hundreds_of_certificates_agree_with_another_search(name: str) -> None:
    assert_certified(name, 100)


def made_up(**changes: Any) -> Certificate:
    """Eight levels, one robot, two policies: the first one fails in levels 4 to 7, the other in 6 and 7."""
    ones = np.ones((8, 1), np.float32)
    outcome = np.zeros((2, 8, 1), np.uint8)
    outcome[0, 4:], outcome[1, 6:] = 1, 2
    whole: dict[str, Any] = {
        "name": "made up", "scenario_hash": "0", "split": "test", "agents": ("robot_0",), "policies": ("dash", "orca"),
        "hash": np.arange(8, dtype=np.uint64), "reachable": ones > 0, "length": 3 * ones, "straight": 2 * ones,
        "clearance": ones, "least_time": np.array([[8], [1], [2], [3], [4], [5], [7], [6]], np.float32),
        "density": ones[:, 0], "outcome": outcome, "time": np.ones((2, 8, 1), np.float32),
    }  # fmt: skip
    return Certificate(**{**whole, **changes})


def test_difficulty_is_the_share_of_failures_and_time_breaks_ties(tmp_path: Path) -> None:
    certificate = made_up()
    assert certificate.difficulty.tolist() == [0, 0, 0, 0, 0.5, 0.5, 1, 1]
    assert certificate.tortuosity[0, 0] == 1.5
    assert certificate.quarters().tolist() == [1, 0, 0, 1, 2, 2, 3, 3]
    assert certificate.quarters(4).tolist() == [3, 0, 1, 2]
    (tmp_path / "c.npz").write_bytes(certificate.content())
    again = read_certificate(tmp_path / "c.npz")
    assert again.content() == certificate.content()
    assert again.policies == ("dash", "orca")
    assert certificate.matches(set_hash(np.arange(3, dtype=np.uint64)), 3)
    assert not certificate.matches(set_hash(np.arange(1, 4, dtype=np.uint64)), 3)
    assert certificate.solved.tolist() == [True] * 6 + [False] * 2
    (tmp_path / "c.npz").write_bytes(b"PK")
    with pytest.raises(IrsimGymError, match=r"c.npz is no certificate of levels"):
        read_certificate(tmp_path / "c.npz")


def test_lengths_count_to_a_centimetre_and_times_of_failures_are_not_kept(tmp_path: Path) -> None:
    """Numbers with NaN, infinity and signs of both kinds, which are stored as differences and in multiples of units."""
    nan, inf = np.nan, np.inf
    given = {
        "straight": [[1.234], [2.0], [0.0], [40000.019], [7.0], [7.0], [7.0], [7.0]],
        "length": [[1.5], [inf], [0.004], [40000.02], [6.99], [7.0], [7.0], [7.006]],
        "clearance": [[nan], [inf], [0.014], [0.016], [0.2], [0.2], [0.2], [-0.02]],
        "least_time": [[1.1], [inf], [0.0], [3.0], [3.1], [3.2], [3.3], [3.4]],
        "density": [0.1, 0.123456, 0.0, 0.0, 0.0, 0.0, 0.0, 0.999],
    }
    arrays: dict[str, Any] = {name: np.array(values, np.float32) for name, values in given.items()}
    arrays["time"] = np.stack([arrays["least_time"] + np.float32(0.1), np.full((8, 1), nan, np.float32)])
    (tmp_path / "c.npz").write_bytes(made_up(**arrays).content())
    found = read_certificate(tmp_path / "c.npz")
    assert found.straight.dtype == found.time.dtype == np.float32
    assert found.straight[:4, 0].tolist() == np.array([1.23, 2.0, 0.0, 40000.02], np.float32).tolist()
    assert found.length[:, 0].tolist() == np.array([1.5, inf, 0, 40000.02, 6.99, 7, 7, 7.01], np.float32).tolist()
    np.testing.assert_array_equal(
        found.clearance[:, 0], np.array([nan, inf, 0.01, 0.02, 0.2, 0.2, 0.2, -0.02], np.float32)
    )
    np.testing.assert_array_equal(found.least_time, arrays["least_time"])
    assert found.density[:2].tolist() == np.array([0.1, 0.123], np.float32).tolist()
    np.testing.assert_array_equal(found.time[0, :, 0], np.array([1.2, inf, 0.1, 3.1, 3.2, 3.3, 3.4, 3.5], np.float32))
    assert np.isnan(found.time[1]).all()


def test_certificates_of_format_1_are_read(tmp_path: Path) -> None:
    """A file as earlier versions wrote it: each array under its name, lengths to the millimetre, times of failures."""
    made = made_up(straight=np.full((8, 1), 2.345, np.float32))
    arrays = {name: getattr(made, name) for name in (*WHOLE, *NUMBERS)}
    about = {"name": made.name, "scenario_hash": "0", "split": "test", "agents": ["robot_0"], "levels": 8}
    about |= {"policies": ["dash", "orca"], "versions": {"numpy": "2.4.6"}, "set_hash": made.set_hash}
    np.savez_compressed(tmp_path / "c.npz", about=np.array(json.dumps(about)), **arrays)
    found = read_certificate(tmp_path / "c.npz")
    for name, array in arrays.items():
        np.testing.assert_array_equal(getattr(found, name), array)
    assert (found.agents, found.policies, found.versions) == (made.agents, made.policies, {"numpy": "2.4.6"})
    assert found.quarters().tolist() == made.quarters().tolist()


def test_certificates_of_newer_formats_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "c.npz", about=np.array(json.dumps({"format": 3})))
    with pytest.raises(IrsimGymError, match="its format is 3, and this version of irsim_gym reads 1 and 2"):
        read_certificate(tmp_path / "c.npz")


def test_evaluate_names_its_levels_and_reports_by_difficulty(tmp_path: Path) -> None:
    file = tmp_path / "room.yaml"
    file.write_bytes((configs_folder() / "scenarios" / "cluttered_room.yaml").read_bytes())
    plain = ig.evaluate(file, "dash", levels=8, references=False)
    assert plain.level_set.certificate is None
    assert len(plain.tables) == 2
    episodes = make_episodes(file, n_worlds=8)
    rows = {name: evaluate_team(reference_policy(name), episodes, 8, "test") for name in ("random", "dash")}
    made = certify(episodes, "test", 8, rows)
    assert made.set_hash == plain.level_set.hash
    (tmp_path / "room.certificate.npz").write_bytes(made.content())
    found = ig.evaluate(file, "dash", levels=8, references=False, folder=tmp_path / "out")
    assert made.hash.tolist() == draw_levels(episodes.simulation, ["test"], 8).hashes().tolist()
    solved = [row.outcome == "success" for row in found.rows["dash"]]
    assert [outcome == 0 for outcome in made.outcome[1, :, 0]] == solved
    times = [row.time if row.outcome == "success" else np.nan for row in found.rows["dash"]]
    np.testing.assert_array_equal(rounded(times, "time"), made.time[1, :, 0])
    by_quarter = [np.mean(np.array(solved)[made.quarters() == k]) for k in range(4)]
    assert sorted(by_quarter, reverse=True) == by_quarter
    shown = str(found)
    assert f"set {made.set_hash}, certified" in shown
    assert all(f"{100 * share:.1f} (" in shown for share in by_quarter)
    assert f"{(~made.solved).sum()} of 8 are solved by none" in shown.replace("\n", " ")
    figures = json.loads((tmp_path / "out" / "summary.json").read_text())
    conditions = figures["conditions"]
    assert conditions["unsolved"] == (~made.solved).sum()
    assert figures["worst"] == {"dash": {"5 %": 0.0, "1 %": 0.0}}
    assert (conditions["level_hash"], conditions["certificate"]) == (made.set_hash, "room")


def assert_same_levels(file: Path, count: int) -> None:
    certificate = read_certificate(file)
    name, *given = file.stem.split("-")
    scenario = load_scenario(name, dict(one.split("=") for one in given), warn=False)
    agents = [b for b, body in enumerate(scenario.bodies) if body.name in certificate.agents]
    simulation = ig.compile(scenario, min(count, 50), agents=agents)
    hashes = draw_levels(simulation, [certificate.split], count).hashes()
    moved = np.flatnonzero(hashes != certificate.hash[:count])
    assert not moved.size, f"{name}: {moved.size} levels have moved, first {moved[:3]}; see docs/levels.md"
    assert find_certificate(scenario, certificate.agents, certificate.split, set_hash(hashes), count) is not None


def test_every_benchmark_has_a_certificate() -> None:
    members = shipped_suite().members.values()
    scenarios = [load_scenario(one.scenario, dict(one.parameters), warn=False) for one in members]
    scenarios += [load_scenario(name, warn=False) for name in PUSHING]
    assert sorted(set(map(shipped_certificate, scenarios))) == SHIPPED


@pytest.mark.parametrize("file", SHIPPED, ids=[file.stem for file in SHIPPED])
def test_no_level_has_moved(file: Path) -> None:
    assert_same_levels(file, min(3, read_certificate(file).count))


@pytest.mark.slow
@pytest.mark.parametrize("file", SHIPPED, ids=[file.stem for file in SHIPPED])
def test_none_of_all_levels_has_moved(file: Path) -> None:
    assert_same_levels(file, read_certificate(file).count)
