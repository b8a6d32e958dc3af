"""Cases and studies that need octmip and femlib together; results go to `results/`.

cases                        one file a family of cases: `python -m benchmarks.run NAME`, by the table in `registry`
kinds, readers               questions and files to hold the code against, by the answers of tests/oracles
mutants, corruptions         wrong files and wrong code that checks and tests must find
uav, shells                             studies, each with a command and a page
blind, real, machines, plain                                    studies of the diagnosis
source_map                   the table of levels, and the map of docs/developing.md
"""
