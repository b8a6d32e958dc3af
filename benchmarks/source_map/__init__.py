"""The structure of the source as it is: arrows between files, circles among them, and the map in docs/pictures."""
