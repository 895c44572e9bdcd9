"""`lbr registry`."""
