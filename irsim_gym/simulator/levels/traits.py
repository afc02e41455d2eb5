"""Draws traits of bodies for a level: their speed, and whether they avoid others."""

import numpy as np

from irsim_gym.scenario.entries.body_checks import speed_count
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.world.names import Floats, Ints, Model, Records, State, kernel, mix, record_type, uniform

TRAITS = record_type("low high unyielding", body=np.int64, n_axes=np.int64, least=np.dtype((np.float64, 2)))
"""Bounds of a body's greatest speed [m/s] (low is NaN where nothing is drawn), the probability that it ignores what
moves, how many of its velocities are speeds, and the least of each that its entry allows.
"""

PARTY_GAP = 0.3
"""Distance between the outlines of bodies that walk side by side [m]."""

DRAWN_SPEEDS = frozenset({"velocity_min", "velocity_max", "drawn_speed"})
DRAWN_HEED = frozenset({"heedless"})


def drawn_traits(scenario: Scenario) -> frozenset[str]:
    """Return the fields of the model that differ between worlds because of traits."""
    speeds = any(body.speed_range is not None for body in scenario.bodies)
    heed = any(body.unyielding > 0.0 for body in scenario.bodies)
    return (DRAWN_SPEEDS if speeds else frozenset()) | (DRAWN_HEED if heed else frozenset())


def collect_traits(scenario: Scenario, model: Model) -> Records:
    """Return one record of type ``TRAITS`` for each body of which something is drawn."""
    varied = [b for b, body in enumerate(scenario.bodies) if body.speed_range is not None or body.unyielding > 0.0]
    traits = np.zeros(len(varied), TRAITS)
    for row, b in zip(traits, varied, strict=True):
        body = scenario.bodies[b]
        low, high = (np.nan, np.nan) if body.speed_range is None else body.speed_range
        row["body"], row["low"], row["high"], row["unyielding"] = b, low, high, body.unyielding
        row["n_axes"] = 0 if body.kinematics is None else speed_count(body.kinematics)
        row["least"][: row["n_axes"]] = model.velocity_min[0, b, : row["n_axes"]]
    return traits


def limits_at_ends(traits: Records, model: Model, body: int) -> tuple[Floats, Floats]:
    """Return a body's velocity limits in levels with the least and the greatest speed that may be drawn.

    Args:
        traits: What levels draw, see ``collect_traits``.
        model: Constants.
        body: The body.

    Returns:
        Lower and upper limits [m/s or rad/s], shape ``(2, 3)`` each; equal rows where no speed is drawn.
    """
    low, high = (np.stack([limit[0, body]] * 2) for limit in (model.velocity_min, model.velocity_max))
    for drawn in traits[(traits["body"] == body) & ~np.isnan(traits["low"])]:
        n = int(drawn["n_axes"])
        # Close to 0, a speed has limits in the proportions of any other; 0 itself has none.
        ends = np.maximum([drawn["low"], drawn["high"]], [min(np.finfo(np.float64).tiny, drawn["high"]), 0.0])
        high[:, :n] = ends[:, None]
        low[:, :n] = np.maximum(drawn["least"][:n], -ends[:, None])
    return low, high


@kernel
def draw_traits(worlds: Ints, traits: Records, model: Model, state: State) -> None:
    """Draw speeds, and which bodies ignore everything that moves.

    The stream of the world does not advance: the numbers are derived from its state, which a file of levels holds.

    Reads: state (random).
    Writes: model (drawn_speed, heedless, velocity_max, velocity_min), state (random).
    """
    for w in worlds:
        stream = state.random[w]
        state.random[w] = mix(stream)
        for k in range(traits.shape[0]):
            drawn, b = traits[k], traits[k].body
            if not np.isnan(drawn.low):
                speed = uniform(state.random, w, drawn.low, drawn.high)
                model.drawn_speed[w, b] = speed
                for axis in range(drawn.n_axes):
                    model.velocity_max[w, b, axis] = speed
                    model.velocity_min[w, b, axis] = max(drawn.least[axis], -speed)
            if drawn.unyielding > 0.0:
                model.heedless[w, b] = uniform(state.random, w, 0.0, 1.0) < drawn.unyielding
        # As if nothing had been drawn: levels of a file, which hold the stream and no traits, get the same ones.
        state.random[w] = stream


def watching_bodies(scenario: Scenario) -> list[tuple[str, ...] | None]:
    """Return the distinct values of ``seen_by``. The first is None, which means all."""
    return list(dict.fromkeys([None, *(body.seen_by for body in scenario.bodies)]))


def write_people(scenario: Scenario, model: Model) -> None:
    """Write which bodies see which, and which walk together."""
    _write_watchers(scenario, model)
    _write_parties(scenario, model)


def _write_watchers(scenario: Scenario, model: Model) -> None:
    """Write whose behaviours see which bodies.

    A word that is both the name of a body and of a group means the body.
    """
    rows, names = watching_bodies(scenario), {body.name for body in scenario.bodies}
    for row, words in enumerate(rows):
        groups = set(words or ()) - names
        for b, body in enumerate(scenario.bodies):
            model.watchers[row, b] = words is None or body.name in words or body.role in words
            model.watchers[row, b] |= body.group_name in groups
    for b, body in enumerate(scenario.bodies):
        model.seen_row[b] = rows.index(body.seen_by)


def _write_parties(scenario: Scenario, model: Model) -> None:
    """Write which bodies walk together: side by side, with the first in the middle.

    Small groups of people walk so (Moussaid et al. 2010, "The walking behaviour of pedestrian social groups").
    """
    model.leader[:] = np.arange(len(scenario.bodies))
    for spec in scenario.placements:
        for k, b in enumerate(spec.members):
            party = scenario.bodies[b].party
            first, place = spec.members[k - k % party], k % party
            model.leader[b] = first
            # Places 0, 1, 2, 3, ... stand at 0, 1, -1, 2, ... gaps to the left of the leader.
            side = (place + 1) // 2 * (1 if place % 2 else -1)
            model.abreast[b] = side * (2.0 * float(model.reach[:, b].max()) + PARTY_GAP)
