"""Utilities without physics: checks of input, units, files, progress, tables, citations."""
