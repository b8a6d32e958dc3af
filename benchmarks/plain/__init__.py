"""The plain selector: the least that a diagnosis has to beat."""
