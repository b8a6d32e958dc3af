"""What is wrong with single channels, found before anything else: stuck, clipped, jumped, with far-off readings."""
