"""The environment that ``irsim_gym.make`` returns. Its errors tell IR-SIM's users what to use instead."""

from typing import Any, NoReturn

import gymnasium
from gymnasium.envs.registration import EnvSpec

BY_HAND = (
    "this is an environment for learning. To run a world by hand, as in IR-SIM, use "
    "irsim_gym.load('my_world.yaml'), or irsim.make('my_world.yaml') with `import irsim_gym.irsim as irsim`"
)
OF_WORLDS = frozenset(
    (
        *("add_object", "add_objects", "create_obstacle", "create_robot", "delete_object", "delete_objects"),
        *("build_tree", "random_polygon_shape", "receive_msg", "validate_unique_names"),
        *("draw_box", "draw_points", "draw_quiver", "draw_quivers", "draw_trajectory", "reset_plot", "set_title"),
        *("get_group_by_name", "get_lidar_offset", "get_lidar_scan", "get_map", "get_object_by_id"),
        *("get_object_by_name", "get_obstacle_info_list", "get_robot_info", "get_robot_info_list", "get_robot_state"),
        *("disable_all_plot", "display", "headless", "save_ani", "save_figure", "show", "quit", "quit_flag"),
        *("done", "end", "pause", "pause_flag", "resume", "refresh", "reload", "set_random_seed", "set_status"),
        *("dynamic_objects", "static_objects", "names", "objects", "obstacle_list", "obstacle_number", "contacts"),
        *("robot", "robot_list", "robot_number", "random_obstacle_position", "load_behavior", "get_msg"),
        *("key_id", "key_vel", "mouse_left_pos", "mouse_pos", "mouse_right_pos"),
        *("logger", "status", "step_mode", "step_time", "time", "world_param"),
    )
)
"""IR-SIM's names for a world that ``irsim_gym.load`` has and an environment has not."""
_NO_ACTION = object()


class Environment(gymnasium.Wrapper[Any, Any, Any, Any]):
    """The unchanged environment; for IR-SIM's names, errors say what to use. It is no part of ``spec``."""

    @property
    def spec(self) -> EnvSpec | None:  # type: ignore[override]
        """What the environment inside was made with."""
        return self.env.spec

    def step(
        self, action: object = _NO_ACTION, action_id: object = None
    ) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Advance by one step, see ``WorldEnv.step``.

        Args:
            action: What the learner does.
            action_id: Of IR-SIM's worlds; nothing may be given here.

        Raises:
            TypeError: There is no action, or an ``action_id``.
        """
        if action is _NO_ACTION or action_id is not None:
            raise TypeError(f"step() takes one action of the learner: {BY_HAND}")
        return self.env.step(action)

    def render(self, *others: object, **named: object) -> Any:
        """Return what the render mode asks for, see ``WorldEnv.render``.

        Raises:
            TypeError: There are arguments.
        """
        if others or named:
            raise TypeError(f"render() takes no arguments, make(..., render_mode='human') opens a window: {BY_HAND}")
        return self.env.render()

    def __getattr__(self, name: str) -> NoReturn:
        if name.startswith("_") or name == "env":  # read before the environment inside exists
            raise AttributeError(name)
        inside = f" (env.unwrapped.{name} exists)" if hasattr(self.unwrapped, name) else ""
        advice = f": {BY_HAND}" if name in OF_WORLDS else ""
        raise AttributeError(f"an environment has no attribute '{name}'{inside}{advice}")
