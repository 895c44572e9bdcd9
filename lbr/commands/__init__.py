"""The subcommands of `lbr`, one module for each."""
