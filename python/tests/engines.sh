#!/usr/bin/env bash
# One fleet on every engine, calm and with workers and drivers killed in the middle: one SHA-256;
# its table as Polars, DuckDB and Spark read it; logs and store on local servers of S3 and Google.
# Installs Dask, Ray and Spark from PyPI and Java 17 from Debian, builds the package and runs
# python/tests/engines and test_objects.py. Ray and Spark are too heavy for every change (1.2 GB);
# run this before a change of python/sesc/fleet is called done, and put its output into
# docs/fleet.md.
#
#     python/tests/engines.sh [--kill worker,driver] [further words for pytest]
#
# SESC_WHEEL names a wheel that is built already.
set -euo pipefail
cd "$(dirname "$0")/../.."
root=$PWD
venv=${CARGO_TARGET_DIR:-target}/engines-venv
if ! command -v java >/dev/null; then
  apt-get update -q
  DEBIAN_FRONTEND=noninteractive apt-get install -y -q openjdk-17-jre-headless
fi
[[ -x $venv/bin/python ]] || python3 -m venv "$venv"
"$venv/bin/pip" install --quiet "maturin>=1.14,<2" numpy pytest hypothesis "distributed" "ray>=2.60" \
  "pyspark>=4.3" pyarrow pandas polars duckdb "moto[server]" s3fs gcsfs gcp-storage-emulator
bin=$(cd "$venv/bin" && pwd)
wheel=${SESC_WHEEL:-}
if [[ ! $wheel ]]; then
  rm -rf "$venv/wheels"
  (cd python && "$bin/maturin" build --quiet --profile dev --out "$bin/../wheels" --interpreter "$bin/python")
  wheel=$(echo "$venv"/wheels/sesc-*.whl)
fi
"$bin/pip" install --quiet --force-reinstall --no-deps "$wheel"
tests=$(mktemp -d)
trap 'rm -r "$tests"' EXIT
cp -r python/tests "$tests"
cd "$tests/tests"
java -version 2>&1 | head -1
"$bin/pip" list --format freeze | grep -E "^(distributed|ray|pyspark)="
SESC_REPOSITORY=$root "$bin/python" -m pytest engines test_objects.py -s --engine executor,dask,ray,spark "$@"
