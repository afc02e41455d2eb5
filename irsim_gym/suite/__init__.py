"""The benchmark suite: its scenarios and levels, and the tables that compare policies on them."""
