"""Everything that carries: the console, its clock, HTTP, WebSocket and the command line; no
formula.
"""
