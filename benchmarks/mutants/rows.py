"""All mutants, one row each."""

from benchmarks.mutants.claims import CLAIMS
from benchmarks.mutants.models import MODELS
from benchmarks.mutants.proofs import PROOFS

MUTANTS = (*CLAIMS, *PROOFS, *MODELS)
