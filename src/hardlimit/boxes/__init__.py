"""Boxes of grains: smooth spheres and disks, event-driven or under Newton's equations; files and kinetic theory."""
