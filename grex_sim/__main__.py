"""``python -m grex_sim`` is ``grex``."""

from grex_sim.cli import main

if __name__ == "__main__":
    main()
