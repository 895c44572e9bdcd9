"""From rows to processes: the plan, the supervisor, and the interfaces for operators."""
