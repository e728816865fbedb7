"""Scripts of other codes: whether an event-driven simulation may replace theirs, and the restitution of a contact."""
