"""Tables and trees as files."""
