"""One contact: balls and the floor, contact laws, approximations, the largest compression."""
