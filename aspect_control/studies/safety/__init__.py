"""What a guard makes of wrong input: every fault under every law, and random sequences of them."""

from .faults import FAULTS, Fault
from .hostile import HostileOutcome, Sequences, hostile_sequence, hostile_sequences
from .table import SafetyRow, safety_table

__all__ = [
    "FAULTS",
    "Fault",
    "HostileOutcome",
    "SafetyRow",
    "Sequences",
    "hostile_sequence",
    "hostile_sequences",
    "safety_table",
]
