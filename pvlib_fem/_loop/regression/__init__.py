"""The refitted model, its tangents, and their products per week."""
