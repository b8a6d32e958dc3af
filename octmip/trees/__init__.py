"""Trees: the problem, its losses and shapes, the methods that solve it, and what proves and recounts the answer.

problem, losses, shape       what is asked: samples, what an answer costs, which trees are allowed
solver, registry, methods    who answers: exact search, local search, mixed-integer forms (`mip`), `regression`
tree, solution, certificate  the answer, and its recount by rules of its own; `proof` reads proof logs
near_sets, tradeoff          all trees near the best; cost against depth, sensors and leaves; trees chosen for new rows
uncertainty, risk            probabilities of leaves, sets of classes, what decisions cost
native, verified             the cores and the checker in Rust; the checker with a theorem in Coq
"""
