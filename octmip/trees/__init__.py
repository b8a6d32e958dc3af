"""Trees: the problem, its losses and shapes, the methods that solve it, and what proves and recounts the answer.

question                     what is asked: samples, what an answer costs, which trees are allowed, risk
solver, runs, methods        who answers: exact search, local search, mixed-integer forms (`mip`), `regression`
nodes, answer, evidence      the tree, the solution and its recount by rules of its own; proof logs and who reads them
near_sets, tradeoff          all trees near the best; cost against depth, sensors and leaves; trees chosen for new rows
uncertainty                  probabilities of leaves, sets of classes
native, verified             the cores and the checker in Rust; the checker with a theorem in Coq
"""
