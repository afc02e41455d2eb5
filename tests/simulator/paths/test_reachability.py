import numpy as np
import pytest

from tests.simulator.paths.scenes import Scene, connected, random_points, random_scene

RADIUS, CELL = 0.2, 0.1
SLACK = float(np.sqrt(RADIUS * RADIUS + 0.5 * CELL * CELL) - RADIUS + CELL / np.sqrt(2.0))
"""A body that is larger by this and gets through proves that the grid finds the way of the body itself."""


def test_nothing_in_the_way() -> None:
    assert Scene().reachable(RADIUS, (1, 1), (5, 5))
    assert Scene().disc(1, 5, 0.5).reachable(RADIUS, (1, 1), (5, 5))


def test_around_a_wall() -> None:
    assert Scene().chain((3, 0), (3, 4)).reachable(RADIUS, (1, 1), (5, 1))
    assert not Scene().chain((3, -1), (3, 7)).reachable(RADIUS, (1, 1), (5, 1))


def test_out_of_a_trap() -> None:
    """A U that opens away from the goal."""
    trap = Scene().chain((1, 1), (4, 1), (4, 5), (1, 5))
    assert trap.reachable(RADIUS, (3, 3), (5.5, 3))
    assert not trap.chain((1, 0), (1, 6)).reachable(RADIUS, (3, 3), (5.5, 3))


def test_out_of_a_spiral() -> None:
    spiral = Scene().chain((0, 1), (5, 1), (5, 5), (1, 5), (1, 2), (4, 2), (4, 4), (2, 4), (2, 3))
    assert spiral.reachable(RADIUS, (3, 3), (0.3, 0.3))
    assert not spiral.chain((0, 5), (1, 5)).reachable(RADIUS, (3, 3), (0.3, 0.3))


def test_a_closed_box() -> None:
    fence = Scene().chain((2, 2), (4, 2), (4, 4), (2, 4), (2, 2))
    assert not fence.reachable(RADIUS, (3, 3), (5, 5))
    assert not fence.reachable(RADIUS, (5, 5), (3, 3))
    assert fence.reachable(RADIUS, (2.5, 3), (3.5, 3))


@pytest.mark.parametrize(("gap", "expected"), [(0.39, False), (0.4, False), (0.58, True), (0.8, True)])
@pytest.mark.parametrize("shift", [0.0, 0.03, 0.05, 0.077])
@pytest.mark.parametrize("turned", [False, True])
def test_a_gap_of_known_width(gap: float, expected: bool, shift: float, turned: bool) -> None:
    """A body of 0.4 m; below that never, from 2 R - 2 r + sqrt(2) h = 0.166 m more on always."""
    low, high = 3.0 + shift, 3.0 + shift + gap
    walls = [((3.0, -1.0), (3.0, low)), ((3.0, high), (3.0, 7.0))]
    scene, start, goal = Scene(), (1.0, 5.0), (5.0, 1.0)
    for a, b in walls:
        scene.chain(a[::-1], b[::-1]) if turned else scene.chain(a, b)
    assert scene.reachable(RADIUS, start, goal) is expected


def test_a_narrow_gap_on_the_straight_way_is_exact() -> None:
    def gap(width: float) -> Scene:
        return Scene().chain((3, -1), (3, 3 - width / 2)).chain((3, 3 + width / 2), (3, 7))

    assert gap(0.4001).reachable(RADIUS, (1, 3), (5, 3))
    assert not gap(0.3999).reachable(RADIUS, (1, 3), (5, 3))


def test_ends_must_be_free() -> None:
    scene = Scene().box(2, 2, 4, 4).disc(1, 5, 0.5)
    assert not scene.reachable(RADIUS, (3, 3), (5, 5))
    assert not scene.reachable(RADIUS, (3, 3), (3.1, 3))
    assert not scene.reachable(RADIUS, (5, 5), (1, 5))
    assert not scene.reachable(RADIUS, (1.85, 3), (5, 5))
    assert scene.reachable(RADIUS, (1.75, 3), (5, 5))


def test_only_the_straight_way_leads_beyond_the_grid() -> None:
    assert Scene().reachable(RADIUS, (1, 1), (9, 1))
    assert not Scene().disc(3, 1, 0.5).reachable(RADIUS, (1, 1), (9, 1))


def test_against_shapely() -> None:
    verdicts = []
    for seed in range(120):
        scene, (start, goal) = random_scene(seed, 8, walled=seed % 3 > 0), random_points(seed, 2)
        found = scene.reachable(RADIUS, start, goal)
        verdicts.append(found)
        if found:
            assert connected(scene, RADIUS - 1e-6, start, goal)
        else:
            assert not connected(scene, RADIUS + SLACK + 5e-3, start, goal)
    assert 0.2 < np.mean(verdicts) < 0.9


def test_both_directions_and_the_mirror_agree() -> None:
    for seed in range(60):
        scene, (start, goal) = random_scene(seed, 9), random_points(seed, 2)
        found = scene.reachable(RADIUS, start, goal)
        assert scene.reachable(RADIUS, goal, start) is found
        flip = np.array([[6.0 - x, y] for x, y in (start, goal)])
        assert scene.mirrored().reachable(RADIUS, *flip) is found
