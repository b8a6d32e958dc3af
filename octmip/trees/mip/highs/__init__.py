"""HiGHS: its runs in processes of their own, the incumbents handed to it, and the claims of it that are believed."""
