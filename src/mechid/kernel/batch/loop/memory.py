"""What the time loop of a batch keeps beside what a kernel does: places behind the kernel's own, of every set."""

from __future__ import annotations

from mechid.kernel.batch.loop.plant import MOST_MODES, SETS
from mechid.kernel.loop.plant import MOST_GUARDS, NS, NY, SIZE

CHUNK = 16  # samples after which a set that had to go alone may come back
FAR = 0.4  # largest turn of a base angle in a step, rad; beyond it a set goes alone
GOING = SIZE  # 1 where a set goes with the others, else 0
START, INTERVAL, STEP, STEP_CLOSE = GOING + 1, GOING + 2, GOING + 3, GOING + 4  # its grid
SAMPLE, NEXT_EDGE = GOING + 5, GOING + 6  # instants of the sample and of the edge that come next
END, COUNT, WHOLE = GOING + 7, GOING + 8, GOING + 9  # until when each goes next, in how many steps of which length
ON_EDGE = GOING + 10  # 1 where an edge is there
LENGTH = GOING + 11  # of the step at hand
SUSPECT = GOING + 12  # 1 where a guard may have fired in it
AWAY = GOING + 13  # 1 where it is not of the usual length
SHARE, FOURFOLD = GOING + 14, GOING + 15  # of the usual length, and its fourth power
SHORT = GOING + 16  # 1 where a set goes on before its sample
IN_MODE = GOING + 17  # mode of each switch
ARMED_SETS = IN_MODE + NS
MARGIN = ARMED_SETS + NS * MOST_GUARDS  # margins and slopes of one mode
SLOPES = MARGIN + MOST_GUARDS  # slopes of all switches
OUTPUT = SLOPES + NS * MOST_GUARDS
PLACES = OUTPUT + NY

NEXT, STALE_SETS = 0, 1  # places in `discrete`: next sample, whether rates are stale
COUNTED = 2  # number of sets: a loop that is seldom entered counts to it, lest it is written out for each
EDGES = 3  # next edge of each set
LEFT_AT = EDGES + SETS  # row in which each set left
PRESENT = LEFT_AT + SETS  # by switch and mode, whether a set came in it
DISCRETE_SETS = PRESENT + NS * MOST_MODES
