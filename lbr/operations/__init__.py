"""Operations: they own the motion, between those who ask for it and the drivers that carry it out."""
