"""Files of every kind, damaged in many ways: each is read, or refused by an error that names it."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from kinds import KINDS, damaged

from irsim_gym.errors import IrsimGymError

QUICK, LONG = 12, 200
FEW = {"policy.zip": 2}
"""Kinds that take long to read, and how many of them are played where the checks are quick."""


def check(kind: str, count: int, seed: int, folder: Path) -> int:
    """Read damaged files; return how many were refused."""
    chosen, refused = KINDS[kind], 0
    folder = folder / "read"
    folder.mkdir()
    file = folder / chosen.name
    chosen.make(file)
    content = file.read_bytes()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        chosen.read(file)
        for number in range(count):
            file.write_bytes(damaged(chosen, content, np.random.default_rng([seed, number])))
            try:
                chosen.read(file)
            except IrsimGymError as error:
                refused += 1
                is_named = chosen.name in str(error) or folder.name in str(error)
                if not is_named:
                    raise AssertionError(f"{kind}, seed {seed}, number {number}: {error}") from error
            except Exception as error:
                error.add_note(f"{kind}, seed {seed}, number {number}")
                raise
    return refused


@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_file_is_read_or_refused_by_name(kind: str, tmp_path: Path) -> None:
    assert check(kind, FEW.get(kind, QUICK), 1, tmp_path) or kind == "curve"  # a curve that is lost is worked out again


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_many_damaged_files(kind: str, tmp_path: Path) -> None:
    check(kind, LONG, 2, tmp_path)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("BARN world", "card")])
def test_a_folder_in_the_place_of_a_file_is_named(kind: str, tmp_path: Path) -> None:
    place = tmp_path / "read" / KINDS[kind].name
    place.mkdir(parents=True)
    if kind == "curve":
        assert KINDS[kind].read(place) == []
        return
    with pytest.raises((IrsimGymError, IsADirectoryError)) as told:
        KINDS[kind].read(place)
    assert str(place.name) in str(told.value)
