"""The command line's `lbr mcp`."""
