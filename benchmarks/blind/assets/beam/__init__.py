"""A family of assets written from scratch: thin-walled strips between rigid ribs, no finite-element package."""
