"""Printed walkers filmed: from pictures to tracks, and from tracks to motion."""
