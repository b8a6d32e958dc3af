"""Two small quadrotors: what the commands of the rotors in hover say about their frames."""
