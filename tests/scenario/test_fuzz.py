"""Whatever stands in a file: a scenario, or a ScenarioError."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from irsim_gym.base.options import option_fields
from irsim_gym.errors import ScenarioError
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.specs.plot_spec import ObjectPlot, WorldPlot
from irsim_gym.scenario.specs.spec import BodyOptions
from irsim_gym.scenario.specs.world_spec import WorldSpec
from irsim_gym.scenario.text.source import SECTIONS, read_file

OPTIONS = (
    "radius center vertices random_shape length width wheelbase range_low range_high number angle_range offset noise"
)
KEYS = sorted({*option_fields(BodyOptions), *option_fields(WorldSpec), *OPTIONS.split(), "type", "3d", "irsim", "<<"})
NAMES = ["circle", "rectangle", "polygon", "linestring", "compound", "diff", "omni", "dash", "rvo", "random", "manual"]
NUMBERS = st.one_of(st.integers(-3, 12), st.floats(), st.integers(), st.sampled_from([0.5, 1.5, 10**400, -0.0]))
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    NUMBERS,
    st.sampled_from([*NAMES, "lidar2d", "cycle", "2*pi", "-pi/2", "1e400", "stop", "state", "$n", "2*$n", "a${n}"]),
    st.text(max_size=5),
)
DATA = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.sampled_from([*KEYS, "name", "zzz"]), inner, max_size=4)
    ),
    max_leaves=12,
)
VECTORS = st.lists(NUMBERS, max_size=4)


def named(*names: str) -> st.SearchStrategy[Any]:
    options = st.dictionaries(st.sampled_from(OPTIONS.split()), st.one_of(NUMBERS, VECTORS, DATA), max_size=3)
    return st.builds(lambda name, rest: {"name": name, **rest}, st.sampled_from(names), options)


def sometimes(strategy: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.one_of(strategy, st.lists(strategy, max_size=3), DATA)


ENTRIES = st.fixed_dictionaries(
    {},
    optional={
        "number": st.one_of(st.integers(0, 4), DATA),
        "number_range": st.one_of(st.lists(st.integers(-1, 4), min_size=2, max_size=2), DATA),
        "shape": sometimes(named("circle", "rectangle", "polygon", "linestring", "compound")),
        "kinematics": sometimes(named("diff", "Diff", "omni")),
        "behavior": sometimes(named("dash", "rvo")),
        "distribution": sometimes(named("random", "circle", "manual")),
        "sensors": sometimes(named("lidar2d")),
        "state": sometimes(VECTORS),
        "goal": sometimes(sometimes(VECTORS)),
        "vel_max": sometimes(VECTORS),
        "angle_range": sometimes(VECTORS),
        "goal_threshold": sometimes(NUMBERS),
        "name": sometimes(st.text(max_size=3)),
        "color": sometimes(st.sampled_from(["r", "cycle", "nonsense"])),
        "plot": st.dictionaries(st.sampled_from([*option_fields(ObjectPlot)]), DATA, max_size=4),
    },
)
DECLARATIONS = st.fixed_dictionaries(
    {"default": SCALARS},
    optional={
        "min": SCALARS,
        "max": SCALARS,
        "choices": st.lists(SCALARS, max_size=3),
        "meaning": st.text(min_size=1, max_size=3),
    },
)
SCENARIOS = st.fixed_dictionaries(
    {},
    optional={
        "world": st.dictionaries(
            st.sampled_from([*option_fields(WorldSpec), *option_fields(WorldPlot)]), DATA, max_size=4
        ),
        "robot": sometimes(ENTRIES),
        "obstacle": sometimes(ENTRIES),
        "irsim": DATA,
        "plot": DATA,
        "gui": DATA,
        "task": DATA,
        "parameters": st.one_of(st.dictionaries(st.sampled_from(["n", "m", "2", "seed"]), DECLARATIONS), DATA),
    },
)
pytestmark = pytest.mark.filterwarnings("ignore::irsim_gym.errors.ScenarioWarning")
QUICK = settings(max_examples=3 * settings().max_examples // 2, suppress_health_check=list(HealthCheck))


def outcome(data: Any) -> Scenario | ScenarioError:
    try:
        return load_scenario(data)
    except ScenarioError as error:
        return error


def check(data: Any) -> None:
    result = outcome(data)
    if isinstance(result, ScenarioError):
        assert result.problems
        assert all(problem.message and len(problem.message) < 400 for problem in result.problems)
        return
    assert len({body.name for body in result.bodies}) == len(result.bodies)
    assert sorted(b for spec in result.placements for b in spec.members) == list(range(len(result.bodies)))


@QUICK
@given(st.dictionaries(st.one_of(st.sampled_from([*SECTIONS, "irsim"]), st.text(max_size=3)), DATA, max_size=4))
def test_any_mapping(data: Any) -> None:
    check(data)


@QUICK
@example({"obstacle": {"shape": [{"name": "polygon", "number": 10**390}]}})
@given(SCENARIOS)
def test_anything_like_a_scenario(data: Any) -> None:
    check(data)


@QUICK
@given(DATA)
def test_anything_in_a_file(tmp_path: Path, data: Any) -> None:
    file = tmp_path / "fuzz.yaml"
    file.write_text(yaml.safe_dump(data, allow_unicode=True), encoding="utf-8")
    check(file)


@QUICK
@given(st.text(alphabet="ab:-[]{}&*<>!|'\"#%@?,.\t\n ~0é\x00", max_size=40))
def test_any_text(tmp_path: Path, text: str) -> None:
    file = tmp_path / "fuzz.yaml"
    file.write_text(text, encoding="utf-8")
    check(file)


@QUICK
@given(st.binary(max_size=30))
def test_any_bytes(tmp_path: Path, raw: bytes) -> None:
    file = tmp_path / "fuzz.yaml"
    file.write_bytes(raw)
    check(file)


@QUICK
@given(
    st.recursive(
        st.one_of(st.none(), st.booleans(), st.integers(), st.floats(allow_nan=False), st.text(max_size=5)),
        lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=4), inner, max_size=3)),
        max_leaves=8,
    )
)
def test_reads_what_pyyaml_reads(tmp_path: Path, data: Any) -> None:
    file = tmp_path / "same.yaml"
    file.write_text(yaml.safe_dump(data, allow_unicode=True), encoding="utf-8")
    assert read_file(file).data == yaml.safe_load(file.read_text(encoding="utf-8"))
