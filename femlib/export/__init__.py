"""Export: any shells as a deck of another program, and what that program found."""
