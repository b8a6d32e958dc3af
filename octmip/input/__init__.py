"""Files, cells, names and JSON values as they are read, each checked before use, and the words for wrong ones."""
