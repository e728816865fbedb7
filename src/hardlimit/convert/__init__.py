"""Restitution into the damping, time step and input of particle codes, and back."""

from .conversion import Conversion, Obtained, convert, convert_back

__all__ = ["Conversion", "Obtained", "convert", "convert_back"]
