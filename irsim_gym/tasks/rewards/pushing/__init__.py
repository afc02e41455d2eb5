"""What is rewarded of bodies that are pushed."""
