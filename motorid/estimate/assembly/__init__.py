"""From a solution to the estimate: values with their standing, remarks, suspects, curves."""
