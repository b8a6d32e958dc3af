"""The standard shell problems, each one case that femlib and its peers solve alike."""
