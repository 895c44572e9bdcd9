"""`lbr import`, and `lbr motion`: files in and out, the balance of motions, and the jobs of the page's builder."""
