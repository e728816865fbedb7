"""Pictures of results: plots and films."""
