"""Reference rows and policies of the shelf, for the pages and films of scenarios."""

from __future__ import annotations

import json
from functools import cache

from irsim_gym.evaluation.saved_policies.cards import PolicyCard
from irsim_gym.evaluation.saved_policies.shelf import card_of, shelf_files
from irsim_gym.evaluation.suite.suite_record import SuiteRecord
from irsim_gym.scenario.specs.library import references_file


@cache
def references() -> SuiteRecord:
    """Return the shipped reference rows of the suite."""
    return SuiteRecord(**json.loads(references_file().read_text(encoding="utf-8")))


def cards_in(scenario: str) -> list[PolicyCard]:
    """Return the cards of the shipped policies that were trained in a scenario."""
    cards = map(card_of, shelf_files())
    return [card for card in cards if card is not None and card.scenario.name == scenario]
