"""An emulated servo bus on a pty, clients that read from it, and what its line can carry."""
