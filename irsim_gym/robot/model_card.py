"""The README.md of an exported policy: a model card for people, with a front matter that hubs read."""

from textwrap import fill

from irsim_gym.robot.contract import RobotContract
from irsim_gym.tasks.terms.term import NEEDS

WIDTH = 120
PERCEIVE = "| `perceive.py` | `SeenMap`, which the driver keeps: a map of the scans, and the way on it; NumPy alone |\n"
SEEN = """
import json
from perceive import SeenMap

contract, maps = json.load(open("contract.json")), {}
for k, level in enumerate(check["level"]):
    seen = maps.setdefault(level, SeenMap(contract))
    way = seen.way(*(check[name][k] for name in ("ranges", "pose", "goal")))
    assert np.allclose(way, check["way_on_seen_map"][k], rtol=0.0, atol=1e-5)
"""
CARD = """---
library_name: irsim_gym
tags: [reinforcement-learning, robotics, navigation, onnx, irsim_gym]
model-index:
  - name: {name}
    results:
      - task: {{type: reinforcement-learning, name: reinforcement-learning}}
        dataset: {{type: "irsim_gym/{scenario}", name: "irsim_gym/{scenario}"}}
        metrics:
          - {{type: success_rate, name: success_rate, value: "{rate}", verified: false}}
---

# {name}

{what}

{needs}

| file | content |
|---|---|
| `policy.onnx` | from raw ranges, pose, velocity and goal to a command in SI units; states `x` and `x_next` |
| `contract.json` | what it needs and was tested with, and its tensors; `contract.schema.json` describes the file |
| `check.npz` | inputs and commands, to repeat the check on the target |
| `drive.py` | `Driver`: ROS messages in, velocities out, and why it stands still; NumPy and onnxruntime alone |
| `scans.py` | for the driver: scans of any scanner by the beams of the contract |
{perceive}
Check it on the target:

```python
import numpy as np
import onnxruntime

check, session = dict(np.load("check.npz")), onnxruntime.InferenceSession("policy.onnx")
given = {{one.name: check[one.name] for one in session.get_inputs()}}
assert np.abs(session.run(["command"], given)[0] - check["command"]).max() < 1e-5
{seen}```

Drive, here in a ROS 2 node:

```python
from drive import Driver

driver = Driver("contract.json")
# driver.scan(msg), driver.odometry(msg), driver.goal(msg) or driver.path(msg) in the callbacks, then in a timer:
# *velocity, reason = driver.tick(node.get_clock().now().nanoseconds / 1e9)
```

It stands still, and says why, for a scan or an odometry older than {age:g} s, a clock that jumps back, a scanner that
it was not tested with, more than {lost:.0%} lost beams, numbers that are not finite, a goal in another frame, and
without a goal. After a fault it waits for three good scans.

It has been tested in a simulator only. Raise the wheels first, then drive slowly, with a dead-man switch and a
collision monitor behind it.
"""


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
    ]
    needs = [
        f"It needs {', '.join(f'`{need}` ({NEEDS[need]})' for need in contract.needs) or 'nothing'}.",
        f"A command goes out each {contract.period:g} s: {', '.join(contract.outputs['command'])}.",
    ]
    if scan is not None:
        needs.append(f"Its scan has {scan.beams} beams up to {scan.range_max:g} m; others are mapped to it by angle.")
    if contract.bodies is not None:
        seen = "that move" if contract.bodies.moving else "around it"
        needs.append(
            f"`Driver.bodies` takes the discs {seen} from a tracker; it was tested with {contract.bodies.most}."
        )
    grid = contract.seen_map
    if grid is not None:
        size = " x ".join(f"{count * grid.cell:.3g}" for count in (grid.columns - 2, grid.rows - 2))
        left, low = (corner + grid.cell for corner in grid.origin)
        needs.append(
            f"Its map covers {size} m from ({left:.3g}, {low:.3g}) on, in the frame of the goal. Set "
            "`seen_map.origin` in contract.json so that the robot and its goals lie on it."
        )
    return CARD.format(
        perceive=PERCEIVE if grid else "",
        seen=SEEN if grid else "",
        name=contract.policy,
        scenario=scenario,
        rate=success,
        what=fill(" ".join(what), WIDTH),
        needs=fill(" ".join(needs), WIDTH),
        age=contract.stop.scan_age,
        lost=contract.stop.lost_beams,
    )
