# shellcheck shell=bash
# Builds presets. Sourced by the scripts, which set root (the checkout). Build folders are kept and reused.

# Other checkouts can reuse cached objects, whatever their path.
# ccache caches precompiled headers too if it ignores time macros and the defines of the header.
export CCACHE_SLOPPINESS=${CCACHE_SLOPPINESS:-pch_defines,time_macros}
export CCACHE_BASEDIR=${CCACHE_BASEDIR:-${root:?}} CCACHE_NOHASHDIR=${CCACHE_NOHASHDIR:-1}

# Uses the variables preset, configure, targets and log of build_preset.
configure_and_build() {
  (cd "${root:?}" && cmake --preset "$preset" "${configure[@]}") >>"$log" 2>&1 &&
    (cd "$root" && NINJA_STATUS='[%f/%t] ' cmake --build --preset "$preset" --parallel "$(nproc)" "${targets[@]}" 2>&1) |
    python3 "$root/scripts/lib/progress.py" "$log"
}

# build_preset PRESET [TARGET...]: configures and builds. It shows the compiler's output only if the build fails. In a new folder,
# warnings are errors (FRACTURE_WERROR), because Debian 12's compilers are known and scripts/test then reuses the objects of
# scripts/run. Each library is compiled as one unit there (FRACTURE_UNITY). The settings of a configured folder are kept.
# FRACTURE_CONFIGURE: further cmake arguments, separated by spaces; they override these defaults.
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
    # GCC 12 occasionally fails to write a precompiled header (gt_pch_save, once in hundreds, never twice for the same header), so
    # a build that an internal compiler error stopped is continued once.
    if ! grep -q "internal compiler error" "$log" || ! configure_and_build; then
      tail -60 "$log" >&2
      echo "the build of preset $preset failed; the complete log is build/$preset.log" >&2
      return 1
    fi
    echo "the compiler failed once with an internal error (build/$preset.log); the second attempt succeeded"
  fi
}
