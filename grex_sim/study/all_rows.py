"""All rows of `grex study team`, in the order in which they are printed."""

from grex_sim.study.rows import PAPERS_LAW
from grex_sim.study.rows_beyond import BEYOND
from grex_sim.study.rows_talk import TALK

ROWS = (*BEYOND, *TALK, *PAPERS_LAW)
