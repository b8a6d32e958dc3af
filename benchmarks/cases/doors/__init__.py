"""The doors asked at size: what others made comes in, and what goes out, drawn by the hundred."""
