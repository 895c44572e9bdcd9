"""The user interface in text: the grammar of lines, holding a motion, the terminal and the commands of `lbr`."""
