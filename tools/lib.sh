# Shared by the scripts of this folder: packages, build. Sourced, not run.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"

say() { printf '%s\n' "$*" >&2; }
die() { say "$*"; exit 1; }

# Runs a command as root: directly, or through sudo.
as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"
  elif command -v sudo >/dev/null 2>&1; then sudo "$@"
  else die "needs root or sudo to install packages: $*"
  fi
}

# Systems whose packages are known: Debian 12 and 13, Ubuntu 22.04 and 24.04. Elsewhere CMake says what it misses.
system_name() {
  local ID="" VERSION_ID=""
  # shellcheck disable=SC1090,SC1091
  [ -r "${OS_RELEASE:-/etc/os-release}" ] && . "${OS_RELEASE:-/etc/os-release}"
  printf '%s %s\n' "${ID:-unknown}" "${VERSION_ID:-}"
}

require_known_system() {
  case "$(system_name)" in
    "debian 12" | "debian 13") ;;
    "ubuntu 24.04") build_packages="$build_packages $ipopt_packages" ;;
    "ubuntu 22.04") build_packages="${build_packages/g++ /g++-12 } $ipopt_packages"; export CXX="${CXX:-g++-12}" ;;  # its g++ is 11
    *) die "the packages of this system ($(system_name)) are not known here. Install what tools/lib.sh lists under the names they have; what is missing CMake says: cmake -S . -B build && cmake --build build" ;;
  esac
  if [ "$(system_name)" = "debian 12" ] && dpkg-query -W -f '${Status}' libboost1.81-dev 2>/dev/null | grep -q 'ok installed'; then
    die "libboost1.81-dev is installed and excludes Boost 1.74, which gripline uses; remove it first: apt-get remove libboost1.81-dev"
  fi
}

# What lands is judged with the tools of one system.
require_debian_12() {
  [ "$(system_name)" = "debian 12" ] || die "format and clang-tidy are judged with the versions of Debian 12; here is $(system_name)"
  require_known_system
}

build_packages="g++ cmake ninja-build pkg-config libeigen3-dev libboost-dev libboost-program-options-dev
  libboost-filesystem-dev coinor-libipopt-dev libssl-dev nlohmann-json3-dev pybind11-dev python3-dev python3-numpy"
ipopt_packages="libblas-dev liblapack-dev" # what Ubuntu's Ipopt links and only recommends
test_packages="groff-base libgtest-dev libgmock-dev locales doxygen"
optional_packages="libhdf5-dev libsqlite3-dev libbz2-dev liblz4-dev"
slurm_packages="munge slurmctld slurmd slurm-client"
package_packages="dpkg-dev file"
check_packages="clang clang-tidy clang-format python3"

# Installs what is missing of the packages named; asks the package lists only if something is.
install_packages() {
  local missing=()
  for package in "$@"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return
  say "installing ${missing[*]}"
  as_root env DEBIAN_FRONTEND=noninteractive apt-get update -qq
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# What the report's tests in a real browser need. Where it cannot be had they are skipped, and this says so.
install_browser() {
  ( install_packages chromium ) || say "no Chromium: the report is not tested in a browser"
  command -v node >/dev/null 2>&1 || ( install_packages nodejs npm ) || say "no Node: the report is not tested in a browser"
  [ -d tools/report/node_modules/playwright-core ] && [ -d tools/report/node_modules/@mcap/core ] ||
    ( cd tools/report && npm ci --silent --ignore-scripts ) || say "npm ci failed in tools/report: the report is not tested in a browser"
}

# What parts that few need are built with. Where it cannot be had they are not built, and CMake says so.
install_optional() {
  # shellcheck disable=SC2086
  ( install_packages $optional_packages ) || say "not installed: $optional_packages"
}

# What the tests of sweeps on a cluster need. Where it cannot be had they are skipped, and this says so.
install_slurm() {
  # shellcheck disable=SC2086
  ( install_packages $slurm_packages ) || say "no Slurm: sweeps are not tested on a cluster"
}

# Runs a command; its words are shown only where it fails.
quietly() {
  local words
  words=$("$@" 2>&1) || die "$words"
}

# build TESTS(ON|OFF): configures build/ when needed and builds. A first build is a whole one: sources are joined, unless
# CMake was asked before (cmake --preset dev).
build() {
  local unity=()
  [ -f build/CMakeCache.txt ] || unity=(-DGRIPLINE_UNITY=ON)
  quietly cmake -G Ninja -S . -B build -DGRIPLINE_TESTS="$1" "${unity[@]}"
  cmake --build build
}
