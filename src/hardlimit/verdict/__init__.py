"""How far an event-driven simulation can be trusted: the law of the error, and the check of other codes' scripts."""
