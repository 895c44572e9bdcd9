"""The rules of motion as a simple model, and seeded worlds that try to make the drive kernel break them."""
