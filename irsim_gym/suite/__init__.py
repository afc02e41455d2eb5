"""The benchmark suite: which scenarios, on which levels, and the tables that compare policies on them."""
