"""The lease as a model that `spin` searches to its last state, and its histories replayed on the real decisions."""
