"""What the page of a tree shows: its questions in words, its drawing, its samples, and how it compares."""
