"""Effects of the lift: another distribution along the span, and another place along the chord."""
