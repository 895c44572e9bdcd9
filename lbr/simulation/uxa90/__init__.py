"""An emulated UXA-90 as its serial line shows it: the main board (UIC) and the SAM servos behind it; no I/O."""
