"""Many walks of one scenario: every combination of settings, for every seed, in one table.

``grid`` says which walks there are, ``walker`` walks one of them in whatever process it is given,
``executors`` are those processes, ``folder`` and ``table`` keep what came of it, ``runner`` puts
them together.
"""
