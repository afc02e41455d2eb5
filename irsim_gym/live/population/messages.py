"""Messages of a world that a script steps, and odometry that moves its bodies."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from irsim_gym.live.population.body import Body
from irsim_gym.live.population.population import Population
from irsim_gym.live.session.run_status import RunStatus
from irsim_gym.live.session.session import Session
from irsim_gym.simulator.readings import messages as msgs
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD


class WorldMessages:
    """Reads a world as messages, and takes odometry.

    Args:
        session: The world's bodies.
        status: The status, which is part of the messages.
        population: Views of the bodies.
    """

    def __init__(self, session: Session, status: RunStatus, population: Population) -> None:
        self._session, self._status, self._population = session, status, population

    def get_msg(self, use_inf: bool = False) -> Any:
        """Return the world as a message that owns its arrays, with the names and fields of ``irsim.msg.WorldState``.

        ``objects`` has all bodies, with ``odom``, ``scan`` and ``scans``. ``collision_ids`` has the first body that one
        touches. Goals have the form of ``Body.goal``.

        Args:
            use_inf: A beam without a return is +inf, and one that is shorter than ``range_min`` is -inf, as REP 117
                says. By default they are ``range_max`` and ``range_min``.
        """
        state, scenario = self._session.simulation.state, self._session.simulation.scenario
        when = int(state.step[0]), float(state.time[0])
        bodies = [self._object(body, when, use_inf) for body in self._population.objects]
        return msgs.WorldState(msgs.Header(*when), scenario.name, self._status.text, scenario.world.step_time, bodies)

    def _object(self, body: Body, when: tuple[int, float], use_inf: bool) -> Any:
        vx, vy, rate = np.ravel(body.twist)
        cosine, sine = math.cos(body.orientation), math.sin(body.orientation)
        twist = msgs.planar_twist(cosine * vx + sine * vy, cosine * vy - sine * vx, rate)
        scanners = [sensor for sensor in body.sensors if sensor.options.reading == "ranges"]
        scans = []
        for k, sensor in enumerate(scanners):
            report = sensor.get_scan()
            ranges = np.array(report["ranges"])
            if use_inf:
                far = ranges >= sensor.options.range_max
                ranges = np.where(report["valid"], ranges, np.where(far, np.inf, -np.inf))
            header = msgs.Header(*when, f"{body.name}/laser{f'_{k}' if k else ''}")
            scans.append(msgs.scan_message(header, sensor.options, sensor.angle_list, ranges))
        goal, hit, felt = body.goal, body.hit, body.contact
        return msgs.ObjectState(
            msgs.Header(*when),
            *(body.id, body.name, body.role, body.kinematics, body.shape),
            msgs.odometry(msgs.Header(*when), f"{body.name}/base_link", body.pose, twist),
            *(scans[0] if scans else None, None if goal is None else np.array(goal)),
            *(body.static, body.arrived, body.collided, [] if hit is None else [hit.id], scans),
            *(msgs.Vector3(*map(float, np.ravel(felt.force))), felt.contact_time, felt.air_time),
            [
                msgs.ContactState(
                    *(one.other.id, one.other.name, msgs.Point(*map(float, one.point))),
                    *(msgs.Vector3(*map(float, one.normal)), one.depth, one.force),
                )
                for one in felt.reports
            ],
        )

    def receive_msg(
        self, msg: Any, *, object_name: str | None = None, object_id: int | None = None, refresh: bool = True
    ) -> int:
        """Move bodies to the poses and velocities of a message, and return how many there are.

        Nothing moves if one of them cannot be used. A car that stands keeps its steering angle.

        Args:
            msg: A ``WorldState`` or an ``ObjectState``, whose bodies are found by name, then by number; or an odometry
                of ROS or of these, which by default is the first robot's.
            object_name: The body that a single message is for.
            object_id: Likewise by number; the name goes first.
            refresh: Update flags, scans and status.

        Raises:
            TypeError: It is no such message.
            UnknownNameError: There is no such body.
            ValueError: One body has two states, or a number cannot be used.
        """
        updates = {}
        for one in getattr(msg, "objects", [msg]):
            body = self._target(one, object_name, object_id)
            if body.name in updates:
                raise ValueError(f"the message has two states of '{body.name}'")
            if body.shape != "map":
                updates[body.name] = body, *_planar(body, getattr(one, "odom", one))
        for body, pose, velocity in updates.values():
            body.set_state(pose)
            if velocity is not None:
                body.set_velocity(velocity)
        if refresh:
            self._status.refresh()
        return len(updates)

    def _target(self, message: Any, name: str | None, number: int | None) -> Body:
        if name is None and number is None:
            name, number = getattr(message, "name", None), getattr(message, "id", None)
        if name is not None and (number is None or name in self._population.names):
            return self._population[name]
        return self._population.robot if number is None else self._population[number]


def _planar(body: Body, message: Any) -> tuple[list[float], Sequence[float] | None]:
    """Return the state of a body and the velocity of its drive that an odometry says; None for drives of plugins."""
    try:
        place, turn, twist = message.pose.pose.position, message.pose.pose.orientation, message.twist.twist
        orientation = [float(one) for one in (turn.x, turn.y, turn.z, turn.w)]
        x, y, vx, vy, rate = (float(one) for one in (place.x, place.y, twist.linear.x, twist.linear.y, twist.angular.z))
    except (AttributeError, TypeError, ValueError) as error:
        told = f"a message is a WorldState, an ObjectState or an Odometry, got {type(message).__name__} ({error})"
        raise TypeError(told) from error
    if not np.isfinite([x, y, vx, vy, rate, *orientation]).all() or not any(orientation):
        raise ValueError(f"the odometry of '{body.name}' must have finite numbers and an orientation, got {message!r}")
    heading, base = msgs.Quaternion(*orientation).to_yaw(), body.wheelbase
    steering = math.atan(rate * base / vx) if vx and base else body.steering
    cosine, sine = math.cos(heading), math.sin(heading)
    velocities = {
        DIFFERENTIAL: (vx, rate),
        ACKERMANN: (vx, steering if getattr(body.spec.kinematics, "mode", "steer") == "steer" else rate),
        OMNI_WORLD: (cosine * vx - sine * vy, sine * vx + cosine * vy),
        OMNI_BODY: (vx, vy),
        OMNI_ANGULAR: (vx, vy, rate),
    }
    return [x, y, heading, steering][: body.state_dim], velocities.get(int(body._model.drive[body._b]))
