"""The explorer: a web page, built from the sources in web/, and a local server for it."""

from .server import serve

__all__ = ["serve"]
