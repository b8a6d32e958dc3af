"""Missing readings: what trees lose where some are lost at random, or a gauge is dead."""
