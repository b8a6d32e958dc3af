"""How each command is called: its help, its examples and its arguments, apart from its work.

Help and errors of arguments wait for none of the packages that the work needs (pandas, scikit-learn, scipy).
"""
