"""A friction damper on a test machine: whose tension readings cannot be right, and what its simplest model lacks."""
