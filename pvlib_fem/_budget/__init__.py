"""Error budget of a model: reductions by steps, time scales, unusual days."""
