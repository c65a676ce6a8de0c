"""Where the error of a model is: what steps took of it, time scales, single days."""
