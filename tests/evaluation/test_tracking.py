"""How good tracks are, against the truth."""

from __future__ import annotations

import numpy as np
import pytest
from command_line import run

from irsim_gym.cli.tools import scenario_request
from irsim_gym.evaluation.comparison.tracking import GOOD, NEAR, measure_tracks
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest


@pytest.mark.parametrize("scenario", ["crossing", "wandering_crowd"])
def test_nine_of_ten_velocities_are_right_after_half_a_second(scenario: str) -> None:
    found = measure_tracks(ScenarioRequest(scenario), 8, "dev")
    away, off, wrong = map(np.concatenate, (found.away, found.off, found.wrong))
    assert len(away) > 5_000
    assert (off < NEAR).mean() > 0.92
    assert (wrong <= GOOD).mean() >= 0.9
    assert found.minutes == pytest.approx(8 * 0.5)


@pytest.mark.parametrize("scenario", ["cluttered_room", "jaxnav_single"])
@pytest.mark.parametrize(("chance", "most"), [(0.0, 1.0), (0.1, 3.0)], ids=["all beams", "a tenth is lost"])
def test_what_stands_makes_few_tracks_a_minute(scenario: str, chance: float, most: float) -> None:
    request = scenario_request(scenario, None, False, None, False, [f"lost_beams:chance={chance}"])
    found = measure_tracks(request, 20, "dev")
    assert sum(map(len, found.away)) == 0
    assert found.false <= most * found.minutes


def test_the_command_prints_shares_by_distance(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "tracks", "crossing", "--levels", "2", "--set", "wanderers=6") == 0
    lines = capsys.readouterr().out.splitlines()
    rows = [line.strip("│ ").split("│") for line in lines if " m " in line and "│" in line]
    assert [row[0].strip() for row in rows] == ["0 to 2 m", "2 to 4 m", "4 to 6 m", "6 to inf m", "0 to inf m"]
    counts = [int(row[1]) for row in rows]
    assert sum(counts[:4]) == counts[4] > 1_000
    assert lines[-1].startswith("false tracks a minute: ")
