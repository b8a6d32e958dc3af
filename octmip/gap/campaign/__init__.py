"""What was measured: readings as a campaign, how they are read and doubted, and what their repeats say of the noise."""
