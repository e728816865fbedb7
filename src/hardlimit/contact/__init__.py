"""One contact: balls and floor, contact laws, published approximations, limits of the compression."""
