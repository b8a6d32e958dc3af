"""From a table and the words of a command line to samples: which columns, which rows, which problem."""
