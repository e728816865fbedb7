"""Where a sweep computes: this processor, a GPU, a cluster."""
