"""What goes aboard: mission, guidance, coordination and the estimators of the team mates."""
