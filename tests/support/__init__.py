"""What tests and benchmarks share: a whole robot, its bench, figures, and the machine below them."""
