"""The gap's diagnosis: detection and speed."""
