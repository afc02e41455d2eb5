"""Contact: what the agent feels of what it touches."""

from typing import ClassVar

import numpy as np

from irsim_gym.base.arraytypes import Rays, Records
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.engine import Simulation
from irsim_gym.tasks.terms import EpisodeState, Ints, Model, Shard, State, kernel, kind, option
from irsim_gym.tasks.terms.mirrored import Mirrored, signed
from irsim_gym.tasks.terms.scaling import unit
from irsim_gym.tasks.terms.targets import without_contacts
from irsim_gym.tasks.terms.term import Bound, Needs, Term
from irsim_gym.tasks.terms.words import Columns


@kind
class Contact:
    """The force on the agent ahead and to the left, divided by ``force``, 1 in contact, and ``min(1, t / time)``.

    t is the time for which it has been in contact without a break.
    """

    needs_goal: ClassVar[bool] = False
    needs: ClassVar[Needs] = ("bodies",)

    force: float = option(10.0, gt=0.0, unit="N", meaning="Force that reads 1; greater ones are clipped.")
    time: float = option(1.0, gt=0.0, unit="s", meaning="Time in contact that reads 1.")

    def misfit(self, scenario: Scenario) -> str | None:
        """Return what the scenario lacks, as text."""
        return without_contacts(scenario)

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, Records]:
        """Return what all bodies feel."""
        return {"felt": simulation.context.pushing.felt}

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the four elements."""
        return np.array([-1.0, -1.0, 0.0, 0.0], np.float32), np.ones(4, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        return [
            Columns("force on the robot: ahead", f"F / {self.force:g} N"),
            Columns("force on the robot: to the left", f"F / {self.force:g} N"),
            Columns("1 if it touches another body, else 0"),
            Columns("for how long it has done so", f"t / {self.time:g} s, at most 1"),
        ]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns; what is positive to the left changes its sign."""
        return signed(1.0, -1.0, 1.0, 1.0)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the four elements."""
        write_contact(shard.worlds, term.bound, term.arrays["felt"], state, episode)


@kernel
def write_contact(worlds: Ints, term: Bound, felt: Records, state: State, episode: EpisodeState) -> None:
    """Write force and time in contact of each agent.

    Reads: term (agents, column, options), state (pose).
    Writes: episode (observation).
    """
    options = term.options[0]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            b = term.agents[a]
            own, row = felt[w, b], episode.observation[w, a, term.column : term.column + 4]
            cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
            row[0] = unit((own.x * cosine + own.y * sine) / options.force)
            row[1] = unit((own.y * cosine - own.x * sine) / options.force)
            row[2] = np.float32(1.0 if own.touches else 0.0)
            row[3] = unit(own.contact_time / options.time)
