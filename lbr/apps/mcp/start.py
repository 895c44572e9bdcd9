"""The server for agents, or an error that names the missing extra."""

try:
    from lbr.apps.mcp.capability import Mcp
except ModuleNotFoundError as err:
    raise ImportError(
        f"the server for agents needs the extra 'mcp' ({err.name} is missing): pip install 'lbr[mcp]'"
    ) from err

__all__ = ["Mcp"]
