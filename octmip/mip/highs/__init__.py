"""HiGHS: runs of it in processes of their own, what is fed to it, and what of its claims is believed."""
