"""The server; without its packages, an ImportError that names the extra."""

try:
    from lbr.apps.web.capability import Web
except ModuleNotFoundError as err:
    raise ImportError(f"the web server needs the extra 'web' ({err.name} is missing): pip install 'lbr[web]'") from err

__all__ = ["Web"]
