"""The check on withheld effects: cases are made and sealed, diagnosed without the key, then scored."""
