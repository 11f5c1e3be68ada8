"""Estimators of the team mates: what a craft believes about those it seldom hears."""
