"""The README.md of an exported policy: a model card for people, with a front matter that hubs read."""

from pathlib import Path
from textwrap import fill

from irsim_gym.evaluation.saved_policies.shelf_tables import curves_text
from irsim_gym.robot.contract import RobotContract
from irsim_gym.tasks.terms.term import NEEDS

WIDTH = 120
PERCEIVE = "| `perceive.py` | `SeenMap`, which the driver keeps: a map of the scans, and the way on it; NumPy alone |\n"
SHIELD = "| `shield.py` | `Shield`, for the driver: slows a robot until it can stop before what its scan shows |\n"
CARD = Path(__file__).with_suffix(".md")
"""The text of a card, with the names of what is filled in."""
MAP_CHECK = Path(__file__).with_name("map_check.py.txt")
"""What the check of a policy with a map has besides."""


def model_card(contract: RobotContract, scenario: str) -> str:
    """Return the model card of an export.

    Args:
        scenario: Name of the scenario that it was played in, with its parameters.
    """
    played, scan = contract.results, contract.scan
    percent = [f"{100.0 * share:.1f}" for share in (played.success, played.low, played.high)]
    delay = f", with commands that act {contract.predict:g} s late" if contract.predict else ""
    success = f"{percent[0]} % [{percent[1]}, {percent[2]}] of {played.levels:,} {played.split} levels{delay}"
    what = [
        f"A policy of irsim_gym {contract.irsim_gym} for a robot with the drive `{contract.robot.drive}`.",
        f"It solves {success} of `{scenario}`, with the 95 % interval in brackets.",
        *([f"The graph predicts {contract.predict:g} s ahead."] if contract.predict else []),
        *([f"It loses 5 points at: {curves_text(contract.robustness)}."] if contract.robustness else []),
    ]
    needs = [
        f"It needs {', '.join(f'`{need}` ({NEEDS[need]})' for need in contract.needs) or 'nothing'}.",
        f"A command goes out each {contract.period:g} s: {', '.join(contract.outputs['command'])}.",
    ]
    if scan is not None:
        needs.append(f"Its scan has {scan.beams} beams up to {scan.range_max:g} m; others are mapped to it by angle.")
    if contract.bodies:
        discs, most = f"discs{' that move' if contract.bodies.moving else ''}", contract.bodies.most
        needs.append(f"`Driver.bodies` takes {discs} from a tracker; it was tested with {most} at most.")
    grid = contract.seen_map
    if grid is not None:
        size = " x ".join(f"{count * grid.cell:.3g}" for count in (grid.columns - 2, grid.rows - 2))
        left, low = (corner + grid.cell for corner in grid.origin)
        needs.append(
            f"Its map covers {size} m from ({left:.3g}, {low:.3g}) on, in the frame of the goal. Set "
            "`seen_map.origin` in contract.json so that the robot and its goals lie on it."
        )
    return CARD.read_text(encoding="utf-8").format(
        parts=(PERCEIVE if grid else "") + (SHIELD if contract.shield else ""),
        seen="\n" + MAP_CHECK.read_text(encoding="utf-8") if grid else "",
        name=contract.policy,
        scenario=scenario,
        rate=success,
        what=fill(" ".join(what), WIDTH),
        needs=fill(" ".join(needs), WIDTH),
        age=contract.stop.scan_age,
        lost=contract.stop.lost_beams,
    )
