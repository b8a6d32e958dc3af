"""The kinds of problem that octmip solves: each drawn at random, enumerated, asked and judged in exact arithmetic."""
