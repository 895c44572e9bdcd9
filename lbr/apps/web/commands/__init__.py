"""What the server adds to `lbr doctor`."""
