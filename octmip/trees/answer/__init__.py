"""What is answered: a solution, what it is about, and the certificates that recount it."""
