"""Planner of Hirose, Fukuda and Kikuchi (1986): the standard crab walk, one file per level of
control.
"""
