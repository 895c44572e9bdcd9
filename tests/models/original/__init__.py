"""The programs of the first lbr: its state machine as documented, their tables, and the room of autodock."""
