"""Tasks of configs/tasks in the scenarios that they are made for."""

from __future__ import annotations

from irsim_gym.scenario import load_scenario
from irsim_gym.tasks import Task, load_task


def task(scenario: str, name: str | None) -> Task:
    return load_task(load_scenario(scenario), name)


def test_patient_navigation_is_seen_navigation_with_more_time_to_stand() -> None:
    patient, seen = task("narrow_door", "patient_navigation"), task("narrow_door", "seen_navigation")
    assert (patient.deadlock_time, seen.deadlock_time) == (5.0, 3.0)
    assert (patient.observations, patient.rewards, patient.endings) == (seen.observations, seen.rewards, seen.endings)
    assert patient.max_steps == seen.max_steps == task("narrow_door", None).max_steps
