"""The files of a ROS 1 package."""
