"""From rows to a plan: reads and checks them, and plans again after each change. Starts nothing."""
