# Shared by tools/setup, tools/demo and tools/test: packages, configure, build. Sourced, never run.

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=$(basename "$0")

say() { printf '%s: %s\n' "$program" "$*"; }
fail() { local code=$1; shift; printf '%s: %s\n' "$program" "$*" >&2; exit "$code"; }

# wanted_packages SECTION...: the names of tools/apt-packages.txt in these sections that this machine should have.
wanted_packages() {
  local section line name condition command current=""
  while IFS= read -r line; do
    line=${line%%#*}
    read -r name condition command <<<"$line"
    [[ -z $name ]] && continue
    if [[ $name == \[*\] ]]; then current=${name:1:-1}; continue; fi
    for section in "$@"; do
      [[ $section == "$current" ]] || continue
      [[ $condition == if-no-command ]] && command -v "$command" >/dev/null && continue
      [[ $condition == if-no-file && -e $command ]] && continue
      [[ $condition == unpack ]] && continue
      printf '%s\n' "$name"
    done
  done <"$repository/tools/apt-packages.txt"
}

# missing_packages SECTION...: those of them that are not installed. A name without ":ARCHITECTURE" means this machine's.
missing_packages() {
  local wanted native
  wanted=$(wanted_packages "$@")
  native=$(dpkg --print-architecture)
  # shellcheck disable=SC2086
  comm -23 <(sort -u <<<"$wanted") \
    <(dpkg-query -W -f '${db:Status-Abbrev}${Package}:${Architecture}\n' $wanted 2>/dev/null |
      sed -n "s/^ii *//p" | sed -E "s/:(all|$native)\$//" | sort -u)
}

# missing_architectures "NAME NAME:ARCHITECTURE": those that dpkg does not know yet.
missing_architectures() {
  local name
  for name in $1; do
    [[ $name != *:* ]] || dpkg --print-foreign-architectures | grep -qx "${name#*:}" || printf '%s\n' "${name#*:}"
  done | sort -u
}

# ensure_packages SECTION...: installs what is missing; returns at once where nothing is.
ensure_packages() {
  command -v dpkg-query >/dev/null || fail 1 "this is no Debian system; install the packages of tools/apt-packages.txt by hand"
  local missing
  missing=$(missing_packages "$@" | tr '\n' ' ')
  missing=${missing% }
  [[ -z $missing ]] && return 0

  local as_root=()
  if [[ $(id -u) -ne 0 ]]; then
    if command -v sudo >/dev/null && sudo env true; then  # sudo may be there and not be ours to use
      as_root=(sudo)
    else
      printf '%s: packages are missing; as root, run:\n' "$program" >&2
      missing_architectures "$missing" | sed 's/^/dpkg --add-architecture /' >&2
      printf 'apt-get update && apt-get install -y --no-install-recommends %s\n' "$missing" >&2
      exit 1
    fi
  fi
  install_packages "$missing" "${as_root[@]}"
}

# install_packages "NAME NAME" [sudo]: one apt-get call, once more after a second update (a lock, a changed mirror).
install_packages() {
  local missing=$1; shift
  local apt=("$@" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600)
  say "installing: $missing"
  local attempt architecture
  for architecture in $(missing_architectures "$missing"); do "$@" dpkg --add-architecture "$architecture"; done
  for attempt in 1 2; do
    "${apt[@]}" -qq update || true
    # shellcheck disable=SC2086
    "${apt[@]}" --assume-no --no-install-recommends install $missing 2>/dev/null | grep -E '^(Need to get|After this)' || true
    # shellcheck disable=SC2086
    if "${apt[@]}" install -y --no-install-recommends $missing; then return 0; fi
    [[ $attempt -eq 1 ]] && say "apt-get failed; trying once more"
  done
  fail 1 "apt-get could not install: $missing (see its lines above)"
}

# ensure_peers: the CANopen nodes of npm that tools/hil's tests talk to, in build/peers. Without them those tests skip, or
# fail with ARMSIGHT_REQUIRE_VCAN=1.
ensure_peers() {
  "$repository/tests/vcan/peers/install" "$repository/build/peers" || say "the CANopen peers could not be installed (see above)"
}

# ensure_unpacked SECTION...: the packages of these sections marked "unpack", unpacked below build/unpacked/ARCHITECTURE.
ensure_unpacked() {
  local section name condition current="" folder
  while read -r name condition _; do
    if [[ $name == \[*\] ]]; then current=${name:1:-1}; continue; fi
    [[ $condition == unpack && " $* " == *" $current "* ]] || continue
    folder=$repository/build/unpacked/${name#*:}
    [[ -e $folder/${name%:*} ]] && continue
    say "unpacking: $name"
    mkdir -p "$folder/download"
    (cd "$folder/download" && apt-get -qq download "$name" && dpkg-deb -x "${name%:*}"_*.deb "$folder") ||
      fail 1 "$name could not be had (apt-get update?)"
    rm -r "$folder/download"
    touch "$folder/${name%:*}"
  done < <(sed 's/#.*//' "$repository/tools/apt-packages.txt")
}

# build PRESET [TARGET...]: configures and builds build/PRESET; without targets everything.
build() {
  local preset=$1; shift
  local tree="$repository/build/$preset" launcher=()
  command -v ccache >/dev/null && launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  export CCACHE_SLOPPINESS=pch_defines,time_macros  # without it ccache leaves out whatever uses a precompiled header
  mkdir -p "$tree"
  if [[ ! -f $tree/build.ninja || $repository/CMakePresets.json -nt $tree/build.ninja ]]; then
    say "configuring build/$preset"
    (cd "$repository" && cmake --preset "$preset" "${launcher[@]}") >"$tree/configure.log" 2>&1 ||
      { tail -n 20 "$tree/configure.log" >&2; fail 1 "configuring failed; everything it said: build/$preset/configure.log"; }
  fi
  say "building build/$preset"
  local targets=()
  [[ $# -gt 0 ]] && targets=(--target "$@")
  cmake --build "$tree" "${targets[@]}" || fail 1 "the build of build/$preset failed (the compiler's lines stand above)"
}
