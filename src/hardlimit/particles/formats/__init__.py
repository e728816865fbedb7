"""Formats of files that hold boxes of grains; each reads one frame and appends frames."""
