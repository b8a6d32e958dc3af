"""Constants settled on some families of assets, to be judged on others."""
