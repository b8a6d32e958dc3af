"""What long searches have found so far, in files from which killed ones go on.

envelope            the file: its sum, to which search it belongs, numbers and rows of trees read with care
exact_state         the solved cuts of an exact axis-aligned search
exact_keeper        their file
search_keeper       the finished turns of a local search
two_feature_keeper  the open nodes of a two-feature proof
"""
