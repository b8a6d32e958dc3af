"""The exact core: proofs, budgets, growth."""
