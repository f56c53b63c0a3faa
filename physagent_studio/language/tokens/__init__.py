"""Words: spelling mended, vocabulary, set phrases rewritten into plain ones, measures read.

In: the sentence. Out: a list of tokens with what each may be.
"""
