"""Columns as CSV, and as Parquet where pyarrow is."""

import csv
import importlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from physagent_studio.errors import BackendMissing
from physagent_studio.exchange.files import written


def write_csv(columns: Mapping[str, Sequence[Any]], path: Path) -> None:
    """Columns of one length; None is empty."""
    with written(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(columns)
        rows.writerows(zip(*columns.values(), strict=True))


def parquet_packages() -> tuple[Any, Any]:
    """pyarrow and what it has for Parquet, else BackendMissing."""
    try:
        return importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    except ImportError as error:
        raise BackendMissing(
            "Parquet needs pyarrow: `pip install 'physagent-studio[tables]'`; CSV holds the same"
        ) from error


def write_parquet(columns: Mapping[str, Any], path: Path) -> None:
    """Columns, arrays among them. Raises BackendMissing without pyarrow."""
    arrow, files = parquet_packages()
    with written(path) as partial:
        files.write_table(arrow.table(dict(columns)), partial)
