# shellcheck shell=bash
# Sourced by the scripts, which set root (the checkout): builds presets. A build folder is kept and reused.

# What one checkout has compiled serves the next one, wherever it lies.
# Precompiled headers are cached, too, when ccache trusts what they were made of.
export CCACHE_SLOPPINESS=${CCACHE_SLOPPINESS:-pch_defines,time_macros}
export CCACHE_BASEDIR=${CCACHE_BASEDIR:-${root:?}} CCACHE_NOHASHDIR=${CCACHE_NOHASHDIR:-1}

# Uses build_preset's preset, configure, targets and log.
configure_and_build() {
  (cd "${root:?}" && cmake --preset "$preset" "${configure[@]}") >>"$log" 2>&1 &&
    (cd "$root" && NINJA_STATUS='[%f/%t] ' cmake --build --preset "$preset" --parallel "$(nproc)" "${targets[@]}" 2>&1) |
    python3 "$root/scripts/lib/progress.py" "$log"
}

# build_preset PRESET [TARGET...]: configures and builds. It shows the compiler's output only if it fails. In a new folder
# warnings are errors (FRACTURE_WERROR), because Debian 12's compilers are known and scripts/test need not compile again what
# scripts/run has. The sources of a library are compiled as one unit there (FRACTURE_UNITY). A configured folder stays as it is.
# FRACTURE_CONFIGURE: further arguments of cmake, with spaces between them; they win over these defaults.
build_preset() {
  local preset=$1 log targets=() configure=() further=()
  shift
  [[ -f ${root:?}/build/$preset/CMakeCache.txt ]] || configure+=(-DFRACTURE_UNITY=ON -DFRACTURE_WERROR=ON)
  read -ra further <<<"${FRACTURE_CONFIGURE:-}"
  configure+=("${further[@]}")
  [[ $# -eq 0 ]] || targets=(--target "$@")
  log=${root:?}/build/$preset.log
  mkdir -p "$root/build"
  echo "== building preset $preset${*:+ ($*)}"
  : >"$log"
  if ! configure_and_build; then
    # GCC 12 now and then fails to write a precompiled header (gt_pch_save, once in hundreds, never twice for the same one):
    # what an internal error of the compiler stopped goes on, once.
    if ! grep -q "internal compiler error" "$log" || ! configure_and_build; then
      tail -60 "$log" >&2
      echo "the build of preset $preset failed; the whole log is build/$preset.log" >&2
      return 1
    fi
    echo "the compiler failed once with an internal error (build/$preset.log), and not again"
  fi
}
