"""`lbr view`."""
