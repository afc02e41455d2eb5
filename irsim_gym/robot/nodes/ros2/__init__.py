"""The files of a ROS 2 package."""
