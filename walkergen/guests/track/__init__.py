"""Printed walkers filmed: from pictures to tracks, and what tracks say."""
