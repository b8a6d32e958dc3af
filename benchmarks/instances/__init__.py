"""The mixed-integer programs of optimal trees as files for any solver, and the table of what is known of them."""
