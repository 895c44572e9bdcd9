"""The motions of the emulated UXA-90: how they are made, and whether its body survives them."""
