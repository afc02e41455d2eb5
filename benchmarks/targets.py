"""What is to be reached: ratios of figures measured in one run, and what the committed results say of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

Results = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Target:
    """A ratio, or a single figure, and how large or small it should be.

    Attributes:
        text: What it says.
        case: The case of the figures.
        figure: The numerator.
        over: The denominator; empty where the figure itself counts.
        least: What has to be reached.
        aim: What is aimed at.
    """

    text: str
    case: str
    figure: str
    over: str
    least: float
    aim: float

    @property
    def more_is_better(self) -> bool:
        """Whether larger is better: the aim lies above what has to be reached."""
        return self.aim > self.least

    def value(self, results: Results) -> float | None:
        """Return what the results say; None where a figure is not there."""
        upper = results.get(self.case, {}).get(self.figure)
        lower = results.get(self.case, {}).get(self.over) if self.over else 1.0
        return None if upper is None or not lower else upper / lower

    def verdict(self, results: Results) -> str:
        """Return ``aim``, ``reached``, ``missed`` or ``not measured``."""
        value = self.value(results)
        if value is None:
            return "not measured"
        sign = 1.0 if self.more_is_better else -1.0
        if sign * value >= sign * self.aim:
            return "aim"
        return "reached" if sign * value >= sign * self.least else "missed"


IRSIM, VMAS, JAXNAV, NAVGROUND, OURS = (f"{who}_median_us" for who in ("irsim", "vmas", "jaxnav", "navground", "ours"))

EVERYTHING = "frames/everything"

TARGETS = (
    Target("S1 `gym.Env.step`: times faster than IR-SIM in a gym wrapper", "s1_single", IRSIM, OURS, 150, 500),
    Target("S1 `gym.Env.step` [us]", "s1_single", "ours_us", "", 10, 3),
    Target("S1 batch 1,024: times faster than IR-SIM in a gym wrapper", "s1_batch", IRSIM, OURS, 1200, 2500),
    Target("S1 batch 1,024, core: its time over the C twin's", "s1_batch", "ours_core_us", "ours_twin_us", 1.6, 1.3),
    Target("S1 batch 1,024: times faster than VMAS, batch 1,024", "s1_batch", VMAS, OURS, 80, 200),
    Target("S1 batch 1,024: times faster than JaxNav, batch 64", "s1_batch", JAXNAV, OURS, 80, 200),
    Target("S3 cave, batch 64: times faster than IR-SIM", "s3_cave", IRSIM, OURS, 300, 900),
    Target("S3 floor plan, batch 64: times faster than IR-SIM", "s3_floor_plan", IRSIM, OURS, 500, 1500),
    Target("S4, batch 1,024: times faster than IR-SIM", "s4", IRSIM, OURS, 400, 1300),
    Target("S4, batch 1,024: times faster than VMAS", "s4", VMAS, OURS, 50, 130),
    Target("S5, pushing, batch 1,024: times faster than IR-SIM", "s5", IRSIM, OURS, 500, 2000),
    Target("S5, pushing, one world: times faster than IR-SIM", "s5", IRSIM, "ours_single_median_us", 100, 500),
    Target("ORCA, 100 agents: times faster than navground", "orca_100", NAVGROUND, OURS, 2, 10),
    Target("ORCA, 1,000 agents: times faster than navground", "orca_1000", NAVGROUND, OURS, 2, 10),
    Target("ORCA, an agent of 10,000 over one of 100", "growth/agents", "10000_agents_us", "100_agents_us", 1.5, 1.1),
    Target("Sampled RVO, 10 robots: times faster than IR-SIM", "s2_rvo", IRSIM, OURS, 50, 130),
    Target(
        "Two threads, S1 batch 1,024: times faster than one",
        "growth/threads",
        "s1_1024_worlds_2_threads_times_faster",
        "",
        1.6,
        1.9,
    ),
    *(
        Target(
            f"PPO with S1, {n} worlds: share of a no-op's frames",
            "training_noop/s1",
            f"{n}_worlds_share_of_noop",
            "",
            0.9,
            0.97,
        )
        for n in (8, 64, 512)
    ),
    Target("VectorEnv above the core, batch 1,024 [us]", "s1/faces", "vector_env_above_core_us", "", 0.1, 0.05),
    Target("VecEnv above the core, batch 1,024 [us]", "s1/faces", "vec_env_above_core_us", "", 0.1, 0.05),
    Target("First step of S1, cold [s]", "startup", "s1_cold_first_step_s", "", 15, 8),
    Target("First step of S1, warm [s]", "startup", "s1_warm_first_step_s", "", 1.0, 0.6),
    Target("`import irsim_gym` [s]", "startup", "import_s", "", 0.3, 0.2),
    Target("Frame with everything on, 600 x 600 [ms]", EVERYTHING, "raster_frame_ms", "", 1.0, 0.7),
    Target("Memory of a world of S1 [KiB]", "memory", "s1_world_kib", "", 64, 16),
)


def table(results: Results) -> list[dict[str, Any]]:
    """Return a row for each target: text, value, what has to be reached, the aim and the verdict."""
    return [
        {
            "text": target.text,
            "value": target.value(results),
            "least": target.least,
            "aim": target.aim,
            "verdict": target.verdict(results),
        }
        for target in TARGETS
    ]
