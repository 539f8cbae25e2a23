"""Faults of hands, links, clients and hosts, tried on a served console; kept in docs/faults.md."""
