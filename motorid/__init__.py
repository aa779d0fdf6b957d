"""motorid: identifies R, L, K, B, J and T0 of a brushed permanent-magnet DC motor on a bench."""

__version__ = "0.1.0"
