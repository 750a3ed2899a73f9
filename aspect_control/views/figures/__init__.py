"""Figures and animations, drawn by matplotlib."""
