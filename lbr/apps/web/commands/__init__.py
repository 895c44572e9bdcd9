"""The server's part of `lbr doctor`."""
