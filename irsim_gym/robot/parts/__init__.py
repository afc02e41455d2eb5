"""What a driver has beside it where its contract asks for it: copied to the robot, and by NumPy alone."""
