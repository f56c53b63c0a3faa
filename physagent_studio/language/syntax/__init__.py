"""Words → phrases and clauses, without meaning.

In: tokens. Out: noun phrases, prepositional phrases and clauses in order.
"""
