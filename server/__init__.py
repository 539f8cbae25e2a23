"""Everything that carries: the real-time loop, HTTP, WebSockets and the command line; no
formula.
"""
