"""True error against time: walkergen, MuJoCo and Drake on one walker."""
