"""What is stored: arrays with named axes, first axis the world."""
