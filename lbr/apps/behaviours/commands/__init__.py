"""`lbr behaviour`, and the trials of a table."""
