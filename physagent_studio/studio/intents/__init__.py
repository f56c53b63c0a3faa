"""Everything that a browser may ask for, as closed and bounded models; `every` lists them."""
