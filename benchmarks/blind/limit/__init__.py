"""The limit of information: a selector that knows the generator of the cases, scored like the diagnosis."""
