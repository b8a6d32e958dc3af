"""The options that say how a table becomes samples; nothing here is slow to import."""

import argparse

from octmip.interfaces.cli.samples.file_arguments import reads

TABLE_HELP = "table: .csv, .tsv (also .gz), .parquet, or - for standard input"


def add_label_arguments(group: argparse._ArgumentGroup, is_required: bool = True, or_folder: bool = False) -> None:
    """Add the table and its label; where it may be a folder of tables, that of each."""
    table, label = TABLE_HELP, "column with the class of each row"
    if or_folder:
        table, label = f"{table}; or a folder of tables", f"{label} (default of a folder: the last of each table)"
    reads(group.add_argument("data", metavar="DATA", help=table))
    group.add_argument("--label", metavar="COL", required=is_required, help=label)


def add_target_arguments(data: argparse._ArgumentGroup, loss: argparse._ArgumentGroup) -> None:
    """Add the column of numbers to predict, and how trees for it are judged."""
    data.add_argument("--target", metavar="COL", help="instead of --label: column with the number of each row")
    loss.add_argument(
        "--loss",
        metavar="LOSS",
        help="with --target: squared or absolute error, or that of a quantile as in quantile:0.9 (default squared)",
    )


def add_leaf_model(group: argparse._ArgumentGroup) -> argparse.Action:
    """Add --leaf-model."""
    return group.add_argument(
        "--leaf-model",
        choices=("constant", "linear"),
        help="with --target: one number in a leaf, or a ridge regression, by search (default constant)",
    )


def add_column_arguments(group: argparse._ArgumentGroup) -> list[argparse.Action]:
    """Add the options that choose columns and rows, and say what becomes of text and of missing cells.

    Returns
    -------
    Those that few people need.
    """
    group.add_argument(
        "--drop",
        metavar="A,B,...",
        action="append",
        help="columns to leave out, in one list or several; a name with a comma in quotes: '\"A,B\",C'",
    )
    return [
        group.add_argument(
            "--features",
            metavar="A,B,...",
            action="append",
            help="columns to split on (default: all but label, weights and index)",
        ),
        group.add_argument("--index", metavar="COL", help="column that names the rows; predict writes it through"),
        group.add_argument("--weights", metavar="COL", help="column with the risk weight of each row (default: all 1)"),
        group.add_argument(
            "--class-weight",
            metavar="A=2,B=1",
            help="weight of each class, or balanced: all classes weigh the same; multiplies --weights (default: all 1)",
        ),
        group.add_argument(
            "--categories",
            choices=("yes-no", "subsets", "order", "refuse"),
            help="text becomes a yes/no question per value, or per set of values (12 at most), its rank in "
            "alphabetical order, or is refused (default yes-no)",
        ),
        group.add_argument(
            "--missing",
            choices=("either-side", "refuse", "drop-rows"),
            default="either-side",
            help="each split sends missing cells to its better side, they are refused, or every row with one is left "
            "out (default either-side)",
        ),
        group.add_argument("--drop-unlabelled", action="store_true", help="leave out the rows without a label"),
        group.add_argument(
            "--numbers-are-classes", action="store_true", help="the label's many numbers are classes, not a quantity"
        ),
    ]


def add_held_out_arguments(group: argparse._ArgumentGroup) -> argparse.Action:
    """Add --holdout and --test, and return the latter."""
    either = group.add_mutually_exclusive_group()
    either.add_argument(
        "--holdout", metavar="SHARE", type=float, help="keep this share of each class for testing, such as 0.25"
    )
    return reads(either.add_argument("--test", metavar="FILE", help="another table to test the tree on"))
