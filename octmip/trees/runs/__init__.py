"""Which solver answers, and the run that is asked of it."""
