"""The explorer: the built page and a server for it. Its sources are in web/."""

from .server import serve

__all__ = ["serve"]
