"""Sequential sensing: sensors read one after the other and paid for when they are read."""
