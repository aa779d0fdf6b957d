"""Population searches on the unit cube, one module for each family; ``registry`` knows them all.

Every search minimises ``f(U[n, d]) -> cost[n]`` and sees a whole population at a time.
"""

from motorid.search.algorithms.population import Cost, Population, Search, SearchResult
from motorid.search.problem import Problem, Solution, solve
from motorid.search.registry import METHODS, minimise

__all__ = [
    "METHODS",
    "Cost",
    "Population",
    "Problem",
    "Search",
    "SearchResult",
    "Solution",
    "minimise",
    "solve",
]
