"""What to use in place of IR-SIM's names that cannot be imported here, and IR-SIM's modules."""

from __future__ import annotations

from irsim_gym.world.irsim_names import CONTACTS

_GROUPS: dict[str, str] = {
    "RRT RRTStar InformedRRTStar PRMPlanner GridPlannerBase TreeNode Node JpsSuccessor": "planners that sample are not "
    "here: world.path(start, goal) is the shortest way for a disc, AStarPlanner the shortest one over the cells of "
    "world.get_map()",
    "env_param EnvParam": "a behaviour gets its own body and the others as arguments; a script has the world that make "
    "returns",
    "world_param WorldParam": "a behaviour's own body has time and step_time; a script has world.world_param",
    "register_kinematics KinematicsHandler KinematicsFactory get_handler_class": "drives in IR-SIM's form are not read "
    "yet: @irsim_gym.drive registers one of your own, kinematics: {name: ...} names it",
    "kinematics_factory differential_kinematics ackermann_kinematics omni_kinematics omni_angular_kinematics "
    "OmniKinematics OmniAngularKinematics DifferentialKinematics AckermannKinematics PassiveKinematics": "the step "
    "moves bodies, and body.step(velocity) moves one alone",
    "Behavior GroupBehavior ObjectGroup OrcaGroupBehavior SfmGroupBehavior behaviors_map behaviors_class_map "
    "group_behaviors_map group_behaviors_class_map": "register_behavior and register_group_behavior register "
    "functions, behavior: {name: ...} and group_behavior: {name: ...} in the file choose them",
    "beh_diff_rvo beh_omni_rvo beh_diff_dash beh_omni_dash beh_omni_angular_dash beh_acker_dash beh_diff_sfm "
    "beh_omni_sfm beh_omni_orca beh_diff_orca beh_omni_sfm_group beh_diff_sfm_group SFMVelocity social_force_model "
    "SocialForceModelBatch": "behavior: {name: dash, rvo or sfm} and group_behavior: {name: orca or sfm} in the file "
    "choose it; DiffDash, OmniDash, AckerDash, DiffRVO and OmniRVO are functions",
    "rng set_seed random_uniform random_point_range": "no generator is shared: irsim.make(file, seed=3) and "
    "world.set_random_seed(3) seed a world, ego.uniform(low, high) draws in a behaviour, numpy.random.default_rng(3) "
    "in a script",
    "generate_polygon random_generate_polygon random_angle_steps clip": "shape: {name: polygon, random_shape: true} "
    "in the file draws an outline",
    "contact_step Contact ContactReport ContactState Contact2D Piece Mtv geometry_pieces object_pieces piece_mtv "
    "object_mtv": CONTACTS,
    "cast_rays cast_ray_segments boundary_segments Lidar2D FMCWLidar2D SensorFactory": "sensors: [{name: lidar2d}] in "
    "the file gives a body a sensor: body.lidar, body.sensors",
    "World World3D ObjectFactory EnvConfig EnvLogger": "irsim.make(file) makes the world and its bodies; logger is "
    "its logger",
    "RobotDiff RobotAcker RobotOmni ObstacleDiff ObstacleAcker ObstacleOmni ObjectStatic": "world.create_robot("
    "kinematics={'name': 'diff'}, ...) and world.create_obstacle(...) add a body",
    "ObstacleMap FogMap GridMapGenerator ImageGridGenerator PerlinGridGenerator generate_perlin_noise "
    "grid_collision_geometry resolve_obstacle_map build_grid_from_generator": "world: {obstacle_map: ...} and "
    "fog_map in the file make a map; world.get_map() is its cells, world.simulation.explored what was seen",
    "EnvPlot EnvPlot3D ObjectPlot VisibilityOptions PatchStyle ImageStyle LineStyle TextStyle TrailStyle ArrowStyle "
    "FovStyle ObjectPlotOptions linewidth_from_data_units geometry_to_path draw_patch set_patch_property "
    "PaletteParam": "render() draws, as the sections `plot` say; world.draw draws over it",
    "KeyboardControl MouseControl": "world.key_vel, key_id and mouse_pos, with render_mode='human'",
    "ObjectInfo ObstacleInfo": "body.info and body.obstacle_info are such records",
    "CircleGeometry PolygonGeometry RectangleGeometry CompoundGeometry LinestringGeometry PointsGeometry "
    "geometry_handler geometry_handler3d": "GeometryFactory.create_geometry(name, ...) makes an outline",
    "Message Header Point Vector3 Quaternion Pose PoseWithCovariance Twist TwistWithCovariance Odometry LaserScan "
    "ObjectState WorldState resolve_message_targets": "there are no messages: body.state, body.velocity and "
    "body.scan() are numbers, body.set_state() takes them",
    "PathManager output_root path_manager file_check find_file": "files are found as Python finds them: pathlib.Path",
    "find_object_by_identity find_duplicates": "world[name], world.get_object_by_name() and get_object_by_id(); "
    "names are unique",
    "log_warning log_warning_once log_error": "world.logger, or Python's logging",
    "bind bind_env plot_only normalize_actions time_it time_it2 validate_shape validate_length ensure_column_vector "
    "ensure_numpy": "it is an inner part of IR-SIM; world.step() takes all forms of actions, time.perf_counter() "
    "measures",
    "convert_list_length convert_list_length_dict is_list_of_dicts is_list_of_numbers is_list_of_lists "
    "is_list_not_list_of_lists traj_to_xy_list points_to_xy_list check_number check_choice fit_length "
    "is_convex_polygon check_unknown_kwargs": "it is an inner part of IR-SIM; numpy and shapely do it in a line",
}

INSTEAD = {name: advice for names, advice in _GROUPS.items() for name in names.split()}
"""What is said of each name."""

_FOLDERS = {
    "": "config env gui lib msg util world version",
    "config.": "env_param palette_param path_param world_param",
    "env.": "env_base env_base3d env_config env_logger env_plot env_plot3d",
    "gui.": "keyboard_control mouse_control",
    "msg.": "messages",
    "util.": "decorator message random util",
    "lib.": "algorithm behavior handler path_planners",
    "lib.algorithm.": "contact generation kinematics ray_casting_2d rvo social_force_model",
    "lib.behavior.": "behavior behavior_methods behavior_registry group_behavior group_behavior_methods",
    "lib.handler.": "geometry_handler kinematics_handler",
    "lib.path_planners.": "a_star grid_planner_base informed_rrt_star jps probabilistic_road_map rrt rrt_star",
    "world.": "map object_base object_factory object_group object_plot obstacles robots sensors world world3d",
    "world.map.": "fog_map grid_map_generator_base image_map_generator obstacle_map perlin_map_generator",
    "world.obstacles.": "obstacle_acker obstacle_diff obstacle_omni obstacle_static",
    "world.robots.": "robot_acker robot_diff robot_omni",
    "world.sensors.": "contact2d fmcw_lidar2d lidar2d sensor_factory",
}

MODULES = tuple(folder + name for folder, names in _FOLDERS.items() for name in names.split())
"""IR-SIM's modules. Each of them can be imported, with all names in it."""
