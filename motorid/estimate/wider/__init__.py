"""Models with more than the six parameters: fitted on demand, or offered when the data ask for it.

``terms`` says what there is, ``screen`` which of it the residuals ask for, ``select`` what the data
support, ``fit`` fits. See docs/wider-models.md.
"""

from motorid.estimate.wider.fit import Fitted
from motorid.estimate.wider.terms import TERMS, Term

__all__ = ["TERMS", "Fitted", "Term"]
