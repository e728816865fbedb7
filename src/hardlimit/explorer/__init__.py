"""The explorer: the built web page, whose sources are in web/, and a local server for it."""

from .server import serve

__all__ = ["serve"]
