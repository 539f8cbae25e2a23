"""Headless runs: their files, logs and figures of merit."""
