"""What people type and see: the grammar of lines, holding a motion, the terminal and the commands of `lbr`."""
