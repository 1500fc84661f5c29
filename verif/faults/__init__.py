"""The fault catalogue: known faults as switchable builds, each caught."""
