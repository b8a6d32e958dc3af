"""Random problems, logs and files: nothing wrong is believed."""
