"""The user interface in text: the grammar of lines, held motions, the terminal and the commands of `lbr`."""
