"""The closed loop: from the residual to the effect that the model misses."""
