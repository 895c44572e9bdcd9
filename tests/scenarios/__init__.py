"""What can go wrong, one function each; shared by the benchmark and the tests."""
