"""Power, second sensors, clear-sky irradiance and mean wind as cross-checks."""
