"""How much of the error a record's columns could still explain, by boosted trees."""
