"""The viser scene."""
