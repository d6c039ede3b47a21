#!/usr/bin/env bash
# Release wheels of the package in target/wheels/, manylinux_2_28 on x86-64 and aarch64, linked by
# zig: one for every Python from 3.10, one for 3.14 without its lock. Each is looked at (tag, size,
# stable ABI, no libpython), and tried in every Python from 3.10 that is there, in an environment
# of its own, where it runs here; that of 64-bit ARM in Debian's Python for it, which qemu runs.
# The one without a lock is tried where there is such a Python, in the hosted CI.
#
#     python/wheels.sh              both
#     python/wheels.sh x86_64       one
set -euo pipefail
cd "$(dirname "$0")/.."
maturin=1.16.0
zig=0.17.1
# Bytes that a wheel may have.
most=$((8 * 1000 * 1000))

processors=("$@")
[[ $# -gt 0 ]] || processors=(x86_64 aarch64)
for processor in "${processors[@]}"; do
  [[ $processor == x86_64 || $processor == aarch64 ]] || { sed -n '2,9s/^# \{0,1\}//p' python/wheels.sh >&2; exit 2; }
done

root=$PWD
out=$root/target/wheels
tools=$root/target/wheel-tools
if [[ ! -x $tools/bin/abi3audit ]]; then
  python3 -m venv "$tools"
  "$tools/bin/pip" install --quiet "maturin==$maturin" "ziglang==$zig" abi3audit
fi
export PATH=$tools/bin:$PATH CARGO_INCREMENTAL=0

# looked_at WHEEL TAG: its tag, its size, its ABI, and what it is linked to.
looked_at() {
  local wheel=$1 size folder library
  [[ $wheel == *-"$2"-manylinux_2_28_*.whl ]] || { echo "$wheel: not tagged $2, manylinux_2_28" >&2; return 1; }
  size=$(stat -c %s "$wheel")
  [[ $size -lt $most ]] || { echo "$wheel: $size bytes, $most at most" >&2; return 1; }
  [[ $2 != *abi3* ]] || abi3audit --strict "$wheel"
  folder=$(mktemp -d)
  python3 -m zipfile -e "$wheel" "$folder"
  library=$(find "$folder" -name '_sesc*.so')
  # By whatever reads ELF files here: the names of shared libraries stand in the file as text.
  if grep -aq 'libpython' "$library"; then
    echo "$wheel: linked to libpython" >&2
    return 1
  fi
  rm -r "$folder"
  echo "$wheel: $size bytes"
}

# pythons: every interpreter from 3.10 that is there, one of each version.
pythons() {
  local found version
  for found in $(compgen -c python3. | grep -xE 'python3\.[0-9]+' | sort -u) \
    "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.*/bin/python3; do
    version=$("$found" -c 'import sys; print("%d.%02d" % sys.version_info[:2])' 2>/dev/null) || continue
    [[ $version < 3.10 ]] || echo "$version $(command -v "$found")"
  done | sort -u -k1,1 | cut -d' ' -f2
}

# tried WHEEL: installed with numpy alone, it finds what is hidden.
tried() {
  local python venv
  for python in $(pythons); do
    venv=$(mktemp -d)
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet "$1"
    (cd "$venv" && bin/python -m sesc.selftest && bin/sesc --version)
    echo "$("$python" -V): passed"
    rm -r "$venv"
  done
}

# emulated WHEEL: on 64-bit ARM in qemu, with Debian's Python and numpy for it unpacked beside the
# tools; a machine where these cannot be had says so.
emulated() {
  local root=$tools/aarch64 python=python3.11 packages
  if ! { command -v qemu-aarch64 && command -v apt-get; } >/dev/null; then
    echo "$1: not tried, there is no qemu-aarch64 or no Debian"
    return
  fi
  if [[ ! -x $root/usr/bin/$python ]]; then
    dpkg --add-architecture arm64
    apt-get update -q
    packages=$(apt-cache depends --recurse --no-recommends --no-suggests --no-conflicts \
      --no-breaks --no-replaces --no-enhances "$python:arm64" libstdc++6:arm64 |
      grep -E '^[a-z0-9.+-]+:arm64$' | sort -u)
    mkdir -p "$root/packages"
    # shellcheck disable=SC2086 # packages are words
    (cd "$root/packages" && apt-get download -q $packages)
    find "$root/packages" -name '*.deb' -exec dpkg -x {} "$root" \;
    "$tools/bin/pip" download --quiet --only-binary=:all: --no-deps --python-version 3.11 \
      --platform manylinux_2_28_aarch64 --dest "$root/packages" numpy
  fi
  rm -rf "$root/site"
  for wheel in "$root"/packages/numpy-*.whl "$1"; do
    python3 -m zipfile -e "$wheel" "$root/site"
  done
  (cd "$root" && PYTHONPATH=$root/site PYTHONNOUSERSITE=1 qemu-aarch64 -L "$root" \
    "usr/bin/$python" -m sesc.selftest)
  echo "$python on aarch64, in qemu: passed"
}

# built TARGET [WORDS FOR MATURIN...]: a wheel in $out; of a Python that is named, maturin knows what
# the build has to be told.
built() {
  maturin build --quiet --release --locked --zig --compatibility manylinux_2_28 --target "$1" \
    --manifest-path python/Cargo.toml --config python/wheel.toml --compression-level 9 \
    --out "$out" "${@:2}"
}

for processor in "${processors[@]}"; do
  target=$processor-unknown-linux-gnu
  rustup target add "$target"
  # `license-files` of pyproject.toml takes it along.
  release/licences sesc-python "$target" >python/LICENSE-CRATES.txt
  rm -f "$out"/sesc-*_"$processor".whl
  built "$target"
  built "$target" --interpreter python3.14t
  free=$(echo "$out"/sesc-*-cp314t-*_"$processor".whl)
  wheel=$(echo "$out"/sesc-*-abi3-*_"$processor".whl)
  looked_at "$free" cp314-cp314t
  looked_at "$wheel" cp310-abi3
  if [[ $processor == "$(uname -m)" ]]; then
    tried "$wheel"
  elif [[ $processor == aarch64 ]]; then
    emulated "$wheel"
  fi
done
