# Sourced by demo.sh and test.sh: takes a bare Debian 12 to a build of a preset. Uses bash and what a minimal system has.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"

say() { printf '==> %s\n' "$*"; }
fail() {
  printf 'argil: %s\n' "$*" >&2
  exit 1
}

# Runs a command as root: directly, or through sudo.
asRoot() {
  if [ "$(id -u)" = 0 ]; then
    "$@"
  elif command -v sudo > /dev/null; then
    sudo "$@"
  else
    fail "packages are missing and there is neither root nor sudo; as root run: apt-get install $missing"
  fi
}

# installPackages [LIST...]: installs what packages.txt, or the lists, name and this system lacks. Touches the network only when something is
# missing.
installPackages() {
  [ "$#" != 0 ] || set -- packages.txt
  missing=""
  local line name
  while read -r line; do
    name="${line%%#*}"
    [ -n "$name" ] || continue
    # A version number alone would also be printed for a package that was removed but not purged.
    if [ "$(dpkg-query -W -f '${db:Status-Status}' "$name" 2> /dev/null)" != installed ]; then
      missing+=" $name"
    fi
  done < <(cd "$root/installer" && cat -- "$@")
  if [ -z "$missing" ]; then
    say "packages: all there"
    return
  fi
  command -v apt-get > /dev/null || fail "these packages are needed and apt-get is not here to install them:$missing"
  say "packages: installing$missing"
  asRoot env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Acquire::Retries=3 update
  # shellcheck disable=SC2086 -- a list of words is meant
  asRoot env DEBIAN_FRONTEND=noninteractive apt-get -qq -y -o Acquire::Retries=3 -o Dpkg::Use-Pty=0 \
    install --no-install-recommends $missing > /dev/null
}

# Compilers at once: one a core, but each may take over a gigabyte where it meets OpenVDB's headers.
buildJobs() {
  local cores kilobytes jobs
  cores="$(nproc)"
  kilobytes="$(awk '/^MemAvailable/ { print $2 }' /proc/meminfo)"
  jobs=$((${kilobytes:-4000000} / 1200000))
  [ "$jobs" -lt "$cores" ] || jobs="$cores"
  [ "$jobs" -ge 1 ] || jobs=1
  echo "$jobs"
}

# buildPreset PRESET [TARGET...]: configures and builds into build/PRESET.
buildPreset() {
  local preset="$1" jobs log
  shift
  jobs="$(buildJobs)"
  log="$root/build/$preset-configure.log"
  mkdir -p "$root/build"
  say "configuring preset $preset"
  if ! (cd "$root" && cmake --preset "$preset") > "$log" 2>&1; then
    cat "$log" >&2
    fail "configuring preset $preset failed"
  fi
  say "building preset $preset with $jobs at once (the first time takes minutes)"
  (cd "$root" && cmake --build --preset "$preset" -j "$jobs" ${1:+--target "$@"})
}
