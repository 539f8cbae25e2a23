"""Transforms, polygons and paths: one place each."""
