"""Scripts that run in other environments; nothing here is imported by the product."""
