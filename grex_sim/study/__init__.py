"""Studies: tables of figures over many runs, each row data."""
