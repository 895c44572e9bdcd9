"""The component `mcp`: tools for language agents."""
