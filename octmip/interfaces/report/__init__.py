"""Results in words, tables, graphs and pages: what a solution says, for people."""
