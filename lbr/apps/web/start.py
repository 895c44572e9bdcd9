"""The server, or the sentence that says what it lacks."""

try:
    from lbr.apps.web.capability import Web
except ModuleNotFoundError as err:
    raise ImportError(f"the web server needs the extra 'web' ({err.name} is missing): pip install 'lbr[web]'") from err

__all__ = ["Web"]
