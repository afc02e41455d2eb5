"""Actions."""


class DeclareLaunchArgument:
    """An argument."""

    def __init__(self, name: str, *, default_value: str) -> None:
        self.name, self.default_value = name, default_value
