"""Figures over all flights of a campaign, from the Parquet files of its tasks, by DuckDB (`pip install duckdb`).

    python3 quantiles.py 'flights/flights-*.parquet'

A row a figure as CSV on stdout: its name, which ends with its unit, the flights that yielded it, their median, and the quantiles
of 5 % and 95 %. What 95 % of the flights keep is the one or the other: an error is at most, a share of valid seconds at least.
"""

import sys

import duckdb

# A file lacks the columns that none of its flights yielded.
QUERY = r"""
WITH runs AS (SELECT COLUMNS('^figures\..*')::DOUBLE FROM read_parquet(?, union_by_name = true)),
     figures AS (UNPIVOT runs ON * INTO NAME figure VALUE value)
SELECT substr(figure, 1 + length('figures.')) AS figure,
       count(*) AS flights,
       median(value) AS median,
       -quantile_disc(-value, 0.95) AS percent_5,
       quantile_disc(value, 0.95) AS percent_95
FROM figures GROUP BY ALL ORDER BY ALL
"""

if len(sys.argv) != 2:
    sys.exit("usage: quantiles.py 'FOLDER/flights-*.parquet'")
duckdb.sql(QUERY, params=[sys.argv[1]]).write_csv("/dev/stdout")
