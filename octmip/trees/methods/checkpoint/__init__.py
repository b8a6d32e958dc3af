"""What solves have found, in a file: the same question is not answered twice, and goes on where it ended.

file          the file: its sums, its version, what belongs to it
entry         what was asked, and what was found of it: a solution, the state of a search
search_state  the state of the two searches that have one: trees and costs that it is about, what is closed
"""
