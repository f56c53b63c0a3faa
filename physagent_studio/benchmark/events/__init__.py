"""Events run end to end: `bench` against references, `view` as a viewer sees them, `ablation`."""
