"""What a long proof has found so far, in a file from which a killed one goes on.

file               the file: its sum, to which search it belongs, the trees and costs that its state is about
exact_state        the solved cuts of an exact axis-aligned search
two_feature_state  the open nodes of a two-feature proof
"""
