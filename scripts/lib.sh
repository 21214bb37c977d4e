# SPDX-License-Identifier: GPL-3.0-or-later
# Functions of the scripts beside this file; to be sourced after `set -euo pipefail`.

project_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
log_dir=$project_dir/build/logs

packages_build=(
  g++ cmake ninja-build ccache pkg-config
  libeigen3-dev libfmt-dev nlohmann-json3-dev libtomlplusplus-dev libcli11-dev
  libceres-dev libarpack2-dev libsuitesparse-dev libmetis-dev libopenblas-dev libfftw3-dev libssl-dev zlib1g-dev
  libopencv-core-dev libopencv-imgproc-dev
  libapriltag-dev
  libavformat-dev libavcodec-dev libavutil-dev
)
# The test framework, the independent programs that some tests compare with, and the compiler of the fuzz targets.
packages_test=(libgtest-dev harminv calculix-ccx ffmpeg clang libclang-rt-14-dev)

say() { printf '\033[1m%s\033[0m\n' "$*" >&2; }

# run_logged NAME COMMAND...: quiet unless it fails; then what it said is shown.
run_logged() {
  local log=$log_dir/$1.log
  shift
  mkdir -p "$log_dir"
  if ! "$@" >"$log" 2>&1 </dev/null; then
    cat "$log" >&2
    printf 'failed: %s (the log above is %s)\n' "$*" "$log" >&2
    return 1
  fi
}

as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    echo "installing packages needs root: run this as root or install sudo" >&2
    return 1
  fi
}

is_installed() {
  [ "$(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

# install_packages NAME...: those of the Debian packages that are not there yet.
install_packages() {
  local missing=() package
  for package in "$@"; do
    is_installed "$package" || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return
  if ! command -v apt-get >/dev/null; then
    echo "not a Debian system; install what corresponds to: ${missing[*]}" >&2
    return 1
  fi
  say "Installing ${#missing[@]} Debian packages: ${missing[*]}"
  run_logged apt-update as_root apt-get update
  run_logged apt-install as_root env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "${missing[@]}"
}

# The chart library of the report, at the version and with the checksum of report/package-lock.json, into build/npm.
install_chart_library() {
  local folder=$project_dir/build/npm
  if [ -e "$folder/node_modules/uplot/package.json" ] &&
    cmp --silent "$project_dir/report/package-lock.json" "$folder/package-lock.json"; then
    return
  fi
  say "Fetching the chart library of the report with npm"
  rm -rf "$folder"
  mkdir -p "$folder"
  cp "$project_dir/report/package.json" "$project_dir/report/package-lock.json" "$folder/"
  run_logged npm npm --prefix "$folder" ci --no-audit --no-fund
}

# Compilers at once: one for each core, but no more than there is memory for.
num_jobs() {
  local memory_per_job_kb=1500000 available_kb cores jobs
  available_kb=$(awk '/^MemAvailable:/ { print $2 }' /proc/meminfo)
  cores=$(env -u OMP_NUM_THREADS -u OMP_THREAD_LIMIT nproc)  # which would count threads by them
  jobs=$((available_kb / memory_per_job_kb))
  if [ "$jobs" -gt "$cores" ]; then jobs=$cores; fi
  if [ "$jobs" -lt 1 ]; then jobs=1; fi
  echo "$jobs"
}

# configure_preset PRESET [CMAKE OPTION...]
configure_preset() {
  cd "$project_dir"
  say "Configuring $1"
  run_logged "configure-$1" cmake --preset "$@"
}

# build_preset PRESET [CMAKE BUILD OPTION...]
build_preset() {
  local jobs
  jobs=$(num_jobs)
  cd "$project_dir"
  say "Building $1, $jobs at a time"
  cmake --build --preset "$@" --parallel "$jobs"
}
