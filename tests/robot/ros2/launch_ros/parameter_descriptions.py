"""Parameters of a type."""

from typing import Any


class ParameterValue:
    """A value."""

    def __init__(self, value: Any, *, value_type: type) -> None:
        self.value, self.value_type = value, value_type
