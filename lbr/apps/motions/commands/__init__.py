"""`lbr import`, and `lbr motion`: files in and out, whether a motion stands, motions that are drawn up."""
