"""A node with a life cycle: its states, and a publisher that is silent while it is not active."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from types import SimpleNamespace
from typing import Any, NamedTuple

from rclpy.qos import QoSProfile
from rclpy.time import Time


class TransitionCallbackReturn(Enum):
    """How a transition went."""

    SUCCESS = 0
    FAILURE = 1
    ERROR = 2


class LifecycleState(NamedTuple):
    """A state."""

    label: str
    state_id: int


class Parameter(NamedTuple):
    """A parameter."""

    name: str
    value: Any


@dataclass(eq=False)
class Publisher:
    """Keeps what it publishes."""

    msg_type: Any
    topic: str
    qos: int
    is_activated: bool = False
    sent: list[Any] = field(default_factory=list)

    def publish(self, msg: Any) -> None:
        """Publish, if the node is active."""
        if self.is_activated:
            self.sent.append(msg)


@dataclass(eq=False)
class Subscription:
    """Waits for messages."""

    msg_type: Any
    topic: str
    callback: Callable[[Any], None]
    qos: QoSProfile | int


@dataclass(eq=False)
class Timer:
    """Waits for a test to call it."""

    period: float
    callback: Callable[[], None]


class LifecycleNode:
    """A node; ``given`` are parameters from outside, ``now`` is its time [s], ``said`` its log."""

    def __init__(self, node_name: str) -> None:
        self.given: dict[str, Any] = {}
        self.name, self.state, self.now = node_name, "unconfigured", 0.0
        self.said: list[str] = []
        self.subscriptions: list[Subscription] = []
        self.publishers: list[Publisher] = []
        self.timers: list[Timer] = []
        self._declared: dict[str, Parameter] = {}

    def has_parameter(self, name: str) -> bool:
        """Return whether it is declared."""
        return name in self._declared

    def declare_parameter(self, name: str, value: Any) -> Parameter:
        """Declare a parameter; one from outside has to be of the default's type."""
        assert name not in self._declared, f"{name} is declared already"
        found = self.given.get(name, value)
        assert type(found) is type(value), f"{name} is {found!r}, not of the type of {value!r}"
        self._declared[name] = Parameter(name, found)
        return self._declared[name]

    def get_parameter(self, name: str) -> Parameter:
        """Return a declared one."""
        return self._declared[name]

    def get_logger(self) -> Any:
        """Return what logs."""
        return SimpleNamespace(info=self.said.append, error=self.said.append)

    def get_clock(self) -> Any:
        """Return the clock."""
        return SimpleNamespace(now=lambda: Time(nanoseconds=round(1e9 * self.now)))

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Callable[[Any], None], qos_profile: QoSProfile | int
    ) -> Subscription:
        """Subscribe."""
        self.subscriptions.append(Subscription(msg_type, topic, callback, qos_profile))
        return self.subscriptions[-1]

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """End a subscription."""
        self.subscriptions.remove(subscription)
        return True

    def create_lifecycle_publisher(self, msg_type: Any, topic: str, qos_profile: int) -> Publisher:
        """Return a publisher that is activated with the node."""
        self.publishers.append(Publisher(msg_type, topic, qos_profile))
        return self.publishers[-1]

    def destroy_lifecycle_publisher(self, publisher: Publisher) -> bool:
        """End a publisher."""
        self.publishers.remove(publisher)
        return True

    def create_timer(self, timer_period_sec: float, callback: Callable[[], None]) -> Timer:
        """Start a timer."""
        self.timers.append(Timer(timer_period_sec, callback))
        return self.timers[-1]

    def destroy_timer(self, timer: Timer) -> bool:
        """End a timer."""
        self.timers.remove(timer)
        return True

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Configure what is managed."""
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Clean up what is managed."""
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Activate the publishers."""
        for publisher in self.publishers:
            publisher.is_activated = True
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Silence the publishers."""
        for publisher in self.publishers:
            publisher.is_activated = False
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End what is managed."""
        return TransitionCallbackReturn.SUCCESS

    def trigger_configure(self) -> TransitionCallbackReturn:
        """Go from unconfigured to inactive."""
        return self._change("unconfigured", "inactive", self.on_configure)

    def trigger_activate(self) -> TransitionCallbackReturn:
        """Go from inactive to active."""
        return self._change("inactive", "active", self.on_activate)

    def trigger_deactivate(self) -> TransitionCallbackReturn:
        """Go from active to inactive."""
        return self._change("active", "inactive", self.on_deactivate)

    def trigger_cleanup(self) -> TransitionCallbackReturn:
        """Go from inactive to unconfigured."""
        return self._change("inactive", "unconfigured", self.on_cleanup)

    def trigger_shutdown(self) -> TransitionCallbackReturn:
        """End."""
        return self._change(self.state, "finalized", self.on_shutdown)

    def _change(
        self, before: str, after: str, act: Callable[[LifecycleState], TransitionCallbackReturn]
    ) -> TransitionCallbackReturn:
        assert self.state == before, f"the node is {self.state}, not {before}"
        result = act(LifecycleState(before, 0))
        if result == TransitionCallbackReturn.SUCCESS:
            self.state = after
        return result
