"""A diagnosis for people and machines: a page of words, a page with figures, one JSON object."""
