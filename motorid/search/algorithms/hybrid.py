"""Hybrids, one scheme for all of them: two searches take turns on one population.

Each partner keeps its own memory (velocities, failure counts) and finds in the population what
the other one left there. The review's Table 11 lists the pairs and no scheme; taking turns by
generation is the plainest.
"""

from __future__ import annotations

from collections.abc import Iterator

from motorid.search.algorithms.population import Population, Search


def hybrid(*partners: Search) -> Search:
    """The search that runs one generation of each partner in turn."""

    def take_turns(population: Population) -> Iterator[None]:
        turns = [partner(population) for partner in partners]
        while True:
            for turn in turns:
                next(turn)
                yield

    return take_turns
