"""The mixed-integer formulations."""
