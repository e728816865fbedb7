"""Boxes of grains: smooth spheres and disks, their files, hard-sphere runs and what theory says of them."""
