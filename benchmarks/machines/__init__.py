"""Machines as users would write them: a twin of fifteen lines, an asset that obeys another model."""
