"""From rows to what should run: read, checked and planned again whenever they change. Starts nothing."""
