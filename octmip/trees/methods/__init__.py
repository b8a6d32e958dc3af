"""Methods: each file answers one Problem with one Solution; beside them what they share on the way."""
