"""Ways in and out: the command `octmip` (`cli`), scikit-learn's estimators, figures (`plot`), pages (`report`)."""
