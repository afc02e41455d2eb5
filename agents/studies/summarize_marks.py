"""Write the tables of five seeds in README.md from results/: a row for each benchmark, and one for each seed.

    irsim-gym train narrow_door --task patient_navigation --seeds 5 --out runs/door
    irsim-gym evaluate narrow_door ppo=runs/door/seed_0,... --out runs/door/own
    python agents/studies/summarize.py narrow_door runs/door/seed_* --test runs/door/own --json-only
    python agents/studies/summarize_marks.py

A file of policies that are played where they were not trained is the `summary.json` of `irsim-gym evaluate`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from summarize import HERE

from irsim_gym.evaluation import ALWAYS_SHOWN
from irsim_gym.suite import reference_figures
from irsim_gym.training import WORST, markdown_table, percent

RESULTS, PAGE = HERE / "results", HERE / "README.md"


@dataclass(frozen=True)
class Mark:
    """Five seeds of one training, and what they are to reach.

    Attributes:
        name: Of the file in ``results``, and of the policy on the shelf.
        benchmark: Where they are trained and played.
        aim: Success that the median is to reach [%].
        planner: Whose row of docs/benchmarks.md stands beside them.
        levels: Number of ``test`` levels that each seed plays.
    """

    name: str
    benchmark: str
    aim: float = 98.0
    planner: str = "seen"
    levels: int = 1000


@dataclass(frozen=True)
class Elsewhere:
    """Seeds of one training where they were not trained.

    Attributes:
        name: Of the file in ``results``.
        trained: Name of their ``Mark``.
        benchmark: Where they are played.
        planner: Whose row of docs/benchmarks.md stands beside them.
    """

    name: str
    trained: str
    benchmark: str
    planner: str = "seen"


@dataclass(frozen=True)
class Shift:
    """A policy on the shelf in benchmarks of the tier *shift* for which it was not trained.

    Attributes:
        policy: Its name.
        home: The benchmark of its training from which its success falls.
        benchmarks: Where it is played.
        planner: Whose row of docs/benchmarks.md stands beside it.
    """

    policy: str
    home: str
    benchmarks: tuple[str, ...]
    planner: str = "seen"


MARKS = (
    Mark("bug_trap", "bug_trap"),
    Mark("narrow_door", "narrow_door"),
    Mark("crossing", "crossing", planner="orca"),
    Mark("crossing_10", "crossing_10", planner="orca"),
    Mark("barn", "barn", 95.0),
    Mark("maze", "maze"),
    Mark("dense_room_memory", "dense_room", 99.0),
    Mark("cluttered_room_memory", "cluttered_room", 99.5, levels=10_000),
    Mark("jaxnav_single", "jaxnav_single"),
    Mark("parking", "parking", 95.0, "hybrid_astar"),
    Mark("crowd_nav", "crowd_nav", 96.9, "orca"),
    Mark("drl_robot_navigation", "drl_robot_navigation", 99.0, "orca"),
)
ELSEWHERE = (
    Elsewhere("narrow_door_in_1.15", "narrow_door", "narrow_door_1.15"),
    Elsewhere("crossing_10_in_3", "crossing_10", "crossing", "orca"),
    Elsewhere("crossing_10_in_6", "crossing_10", "crossing_6", "orca"),
    Elsewhere("maze_in_rooms", "maze", "rooms"),
    Elsewhere("maze_in_0.65", "maze", "maze_0.65"),
    Elsewhere("maze_in_1.0", "maze", "maze_1.0"),
    Elsewhere("maze_in_cellular_cave", "maze", "cellular_cave"),
    Elsewhere("crowd_nav_in_random", "crowd_nav", "crowd_nav_random", "orca"),
    Elsewhere("crowd_nav_in_fast", "crowd_nav", "crowd_nav_fast", "orca"),
    Elsewhere("crowd_nav_in_groups", "crowd_nav", "crowd_nav_groups", "orca"),
    Elsewhere("crowd_nav_in_unyielding", "crowd_nav", "crowd_nav_unyielding", "orca"),
    Elsewhere("crowd_nav_in_policy", "crowd_nav", "crowd_nav_policy", "orca"),
)
MAPS, CROWDS = (
    ("maze", "cellular_cave", "barn"),
    tuple(f"crowd_nav_{name}" for name in ("fast", "groups", "unyielding", "policy")),
)
SHIFTS = (
    Shift("cluttered_room", "cluttered_room", MAPS),
    Shift("cluttered_room_memory", "cluttered_room", MAPS),
    Shift("dense_room_memory", "dense_room", MAPS),
    Shift("general", "cluttered_room", ("barn",)),
    Shift("crowd_nav", "crowd_nav", CROWDS, "orca"),
    Shift("general", "crowd_nav_random", CROWDS, "orca"),
)
OVERVIEW = (
    *("scenario", "`--task`", "aim %", "median %", "interquartile mean % [95 % interval]", "lowest, highest %"),
    *(f"worst {WORST} of all seeds", "planner % [95 % interval]", "CPU s", "steps"),
)
SEEDS = ("scenario", "seed", "success % [95 % interval]", "collision %", "timeout %", "SPL", f"worst {WORST}", "CPU s")
PLAYED = ("trained in", "played in", "levels", "each seed %", "median %", "planner % [95 % interval]")

SHIFTED = (
    "policy",
    "trained in",
    "success there %",
    "played in",
    "success % [95 % interval]",
    "fall, points",
    "planner %",
)

FOUR = (
    *("seed", "SFL's protocol: robots %", "worst 5 %", "windows", "`test`: robots %", "teams % [95 % interval]"),
    *("collision %", "timeout %", "makespan s", "CPU s"),
)


def read(name: str) -> Any:
    """Return a file of ``results``; None where there is none."""
    file = RESULTS / f"{name}.json"
    return json.loads(file.read_text(encoding="utf-8")) if file.is_file() else None


def planner(benchmark: str, method: str) -> str:
    """Return a method's row of docs/benchmarks.md."""
    return f"{percent(reference_figures()[benchmark][method]['success'])}{'' if method == 'seen' else f' (`{method}`)'}"


def overview_row(mark: Mark, found: Any) -> tuple[str, ...]:
    """Return what all seeds of a training came to."""
    seeds = found["seeds"]
    shares = [seed["test"]["success"]["value"] for seed in seeds]
    task = seeds[0]["settings"]["task"] or ""
    return (
        *(mark.benchmark, task, f"{mark.aim:g}", f"{100 * found['median_test_success']:.1f}"),
        *(percent(found["interquartile_mean_test_success"]), f"{100 * min(shares):.1f}, {100 * max(shares):.1f}"),
        *(f"{100 * found['worst_of_method'][WORST]:.0f}", planner(mark.benchmark, mark.planner)),
        *(f"{median(seed['cpu_seconds'] for seed in seeds):.0f}", f"{seeds[0]['steps']:,}"),
    )


def seed_rows(mark: Mark, found: Any) -> Iterator[tuple[str, ...]]:
    """Yield what each seed of a training came to."""
    for seed in found["seeds"]:
        test = seed["test"]
        failed = (f"{100 * test[name]['value']:.1f}" for name in ("collision", "timeout"))
        end = f"{test['spl']:.3f}", f"{100 * test['worst'][WORST]:.0f}", f"{seed['cpu_seconds']:.0f}"
        yield mark.benchmark, str(seed["settings"]["seed"]), percent(test["success"]), *failed, *end


def played_row(place: Elsewhere, found: Any) -> tuple[str, ...]:
    """Return what the seeds of a training came to elsewhere."""
    seeds = [row for row in found["policies"] if row["policy"] not in ALWAYS_SHOWN]
    shares = [100 * row["success"]["value"] for row in seeds]
    trained = next(mark.benchmark for mark in MARKS if mark.name == place.trained)
    return (
        *(trained, place.benchmark, str(found["conditions"]["levels"])),
        *(
            ", ".join(f"{share:.1f}" for share in shares),
            f"{median(shares):.1f}",
            planner(place.benchmark, place.planner),
        ),
    )


def shift_rows(shift: Shift, found: Any) -> Iterator[tuple[str, ...]]:
    """Yield what a policy comes to in each benchmark, and by how much that is less than where it was trained."""
    figures = found["figures"]
    home = figures[shift.home][shift.policy]["success"]
    for benchmark in shift.benchmarks:
        there = figures[benchmark][shift.policy]["success"]
        fall = 100 * (home["value"] - there["value"])
        yield (
            *(shift.policy, shift.home, f"{100 * home['value']:.1f}", benchmark, percent(there), f"{fall:.1f}"),
            planner(benchmark, shift.planner),
        )


def four_rows(scores: Any, found: Any) -> Iterator[tuple[str, ...]]:
    """Yield what each seed of jaxnav_four comes to in SFL's levels, by its protocol, and on test levels."""
    for seed in found["seeds"]:
        (test,), published = seed["test"].values(), scores[f"jaxnav_four.npz {seed['run']}"]
        shares = (test[name]["value"] for name in ("individual_success", "collision", "timeout"))
        robots, collision, timeout = (f"{100 * share:.1f}" for share in shares)
        yield (
            *(str(seed["settings"]["seed"]), f"{100 * published['success']:.1f}"),
            *(f"{100 * published['worst 5 %']:.1f}", str(published["windows"])),
            *(robots, percent(test["cooperative_success"]), collision, timeout),
            *(f"{test['makespan']:.1f}", f"{seed['cpu_seconds']:.0f}"),
        )


def tables() -> dict[str, str]:
    """Return the tables of the page, by the name in their comments; what has no results has no row."""
    marks = [(mark, found) for mark in MARKS if (found := read(mark.name)) is not None]
    played = [(place, found) for place in ELSEWHERE if (found := read(place.name)) is not None]
    shifted, four = read("shift"), (read("jaxnav_score"), read("jaxnav_four"))
    return {
        "marks": _table(OVERVIEW, (overview_row(*one) for one in marks)),
        "marks-seeds": _table(SEEDS, (row for one in marks for row in seed_rows(*one))),
        "marks-elsewhere": _table(PLAYED, (played_row(*one) for one in played)),
        "marks-four": _table(FOUR, four_rows(*four)),
        "marks-shift": _table(SHIFTED, (row for shift in SHIFTS for row in shift_rows(shift, shifted))),
    }


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    return "\n".join(markdown_table(head, list(rows)))


def rewritten(page: str) -> str:
    """Return the page with new tables between their comments."""
    for name, table in tables().items():
        begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
        before, _, rest = page.partition(begin)
        _, _, after = rest.partition(end)
        page = f"{before}{begin}\n{table}\n{end}{after}"
    return page


if __name__ == "__main__":
    PAGE.write_text(rewritten(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
