#!/usr/bin/env bash
# One fleet on Ray and Spark, calm, from the store, and with a worker killed in the middle: one
# SHA-256; its table as Polars, DuckDB and Spark read it. Installs Ray and Spark from PyPI and Java 17
# from Debian (1.2 GB), builds the package and runs python/tests/engines.
#
#     python/tests/engines.sh [words for pytest]
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
"$venv/bin/pip" install --quiet "maturin>=1.14,<2" numpy pytest "ray>=2.60" \
  "pyspark>=4.3" pyarrow pandas polars duckdb
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
"$bin/pip" list --format freeze | grep -E "^(ray|pyspark)="
SESC_REPOSITORY=$root "$bin/python" -m pytest engines "$@"
