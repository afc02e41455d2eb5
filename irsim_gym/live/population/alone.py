"""Parts of a step by themselves: one body moves, scans are taken, flags are found."""

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.session import moves
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.step import step


def move(simulation: Simulation, body: int, command: Floats | None) -> None:
    """Move one body by a step; time, other bodies, flags and readings stay.

    Args:
        simulation: The world.
        body: The body; nothing happens if it never moves.
        command: A command of its drive [m/s or rad/s], shape ``(n,)``; None for that of its behaviour.

    Raises:
        ValueError: The command has a wrong length.
    """
    model, state = simulation.model, simulation.state
    if not model.movable[body]:
        return
    driven, before = bool(model.driven[body]), state.command[0, body].copy()
    if command is not None:
        state.command[0, body] = moves.commands(simulation, {body: command})[1][0]
        model.driven[body] = True  # as for the commands of a step
    try:
        simulation.run(
            lambda shard: step.advance_one(simulation.parts, model, state, shard, body, decides=command is None)
        )
    finally:
        model.driven[body], state.command[0, body] = driven, before


def sense(simulation: Simulation) -> None:
    """Take the readings of all sensors at the present poses."""
    simulation.run(lambda shard: step.sense(simulation.parts, simulation.model, simulation.state, shard))


def find_flags(simulation: Simulation) -> None:
    """Update the flags of all bodies from their present poses."""
    simulation.run(lambda shard: step.find_flags(simulation.parts, simulation.model, simulation.state, shard))
