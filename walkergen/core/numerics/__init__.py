"""Numerics that know no physics: compiled kernels, statistics, a Runge-Kutta pair."""
