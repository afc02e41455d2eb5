"""The state that the parts of a world share: the simulation, names, goals and past poses."""

from typing import Any

from irsim_gym.live.session.goal_writer import GoalWriter
from irsim_gym.live.session.painted import PaintedBeams
from irsim_gym.live.session.roster import Roster
from irsim_gym.live.session.track import Track
from irsim_gym.scenario import Scenario
from irsim_gym.simulator.engine import Simulation, compile


class Session:
    """A compiled scenario with the names, goals and past poses of its bodies.

    Args:
        scenario: What the file says.
        columns: Whether vectors are returned as columns of shape ``(n, 1)``, and points as ``(2, n)``, as in IR-SIM.

    Attributes:
        scenario: What the file says; ``simulation.scenario`` has the bodies that are here now.
        simulation: The simulator; ``compile`` and ``replace`` exchange it.
        roster: Names and numbers of the bodies.
        goals: Writes goals, and restores those of the start.
        track: Poses of bodies since the reset.
        painted: Beams with colours of their own.
        properties: Properties that a script added to bodies, by name of the body.
    """

    simulation: Simulation
    roster: Roster
    goals: GoalWriter

    def __init__(self, scenario: Scenario, *, columns: bool) -> None:
        self.columns = columns
        self.properties: dict[str, dict[str, Any]] = {}
        self.track, self.painted = Track(), PaintedBeams()
        self.compile(scenario)

    def compile(self, scenario: Scenario) -> None:
        """Compile a scenario. ``begin`` draws its level."""
        self.simulation = compile(scenario, check_starts=False)
        self.scenario = scenario
        self.roster, self.goals = Roster(self.simulation), GoalWriter()

    def replace(self, simulation: Simulation) -> None:
        """Continue with a simulation of the same moment that has other bodies."""
        self.simulation = simulation
        self.roster.follow(simulation)
        self.goals.follow(simulation)
        self.track.follow(simulation)
        self.properties = {name: values for name, values in self.properties.items() if name in simulation.parts.names}

    def begin(self, seed: int, episode: int) -> None:
        """Draw a level and begin it."""
        self.simulation.reset(seed, episode=episode)
        self.track.begin(self.simulation)

    def begin_again(self) -> None:
        """Begin the level again, with the present bodies."""
        self.goals.bring_back(self.simulation)
        self.simulation.reset_to_start()
        self.track.begin(self.simulation)
