"""Planner of Kugushev and Jaroshevskij (1975): the gait along a trace, one file per section of the
paper.
"""
