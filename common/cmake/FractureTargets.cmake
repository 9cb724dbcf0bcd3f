# Options shared by all targets of this project, as INTERFACE libraries, and the two functions that create
# targets.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS ON)  # the exact arithmetic uses __int128
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(FRACTURE_CCACHE ccache)
if(FRACTURE_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${FRACTURE_CCACHE})
endif()

# Strict IEEE arithmetic. By default, g++ contracts a*b+c to fma, which breaks the proven error bounds and the
# guarantee of identical bytes from every compiler. Never use -ffast-math. No code here reads errno or the
# floating-point exception flags, so not maintaining them changes no value.
add_library(fracture_strict_fp INTERFACE)
target_compile_options(fracture_strict_fp INTERFACE -ffp-contract=off -fno-math-errno -fno-trapping-math)

add_library(fracture_warnings INTERFACE)
target_compile_options(fracture_warnings INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Wunused
                       -Werror=return-type)
if(FRACTURE_WERROR)
  target_compile_options(fracture_warnings INTERFACE -Werror)
endif()
# g++ 12 reports overlapping copies in "literal" + std::string (GCC bug 105651, fixed in 13).
target_compile_options(fracture_warnings INTERFACE
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>)

# If several sources are compiled as one unit, compilers give false warnings. A local name may equal a name in
# another source of the unit (scripts/check tidy finds real shadowing in each file). g++ also warns about the
# bounds of strings that it has inlined. It also warns about coroutine frames with types from an unnamed
# namespace, although each is used in only one unit.
if(FRACTURE_UNITY)
  target_compile_options(fracture_warnings INTERFACE -Wno-shadow
                         $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage;-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>)
endif()

# g++ collects its garbage whenever it holds 128 MB. A unit with many sources grows to 500 MB, and collecting
# took a tenth of its time.
if(FRACTURE_UNITY)
  target_compile_options(fracture_warnings INTERFACE $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=524288>)
endif()

add_library(fracture_sanitizers INTERFACE)
if(FRACTURE_SANITIZE)
  target_compile_options(fracture_sanitizers INTERFACE -fsanitize=${FRACTURE_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize-recover=all)
  target_link_options(fracture_sanitizers INTERFACE -fsanitize=${FRACTURE_SANITIZE})
  target_compile_definitions(fracture_sanitizers INTERFACE FRACTURE_SANITIZED=1)
  # Enough debugging information for the source positions in a sanitizer's report.
  target_compile_options(fracture_sanitizers INTERFACE -g1)
endif()

# For this folder and its subfolders, which wait for sockets, disks and processes. Under a sanitizer,
# optimizing their templates takes three times as long as compiling them, and does not make their tests
# faster. For fuzzing, optimization is worthwhile.
macro(fracture_unoptimized_under_sanitizers)
  if(FRACTURE_SANITIZE AND NOT FRACTURE_FUZZ)
    add_compile_options(-O0)
    set(FRACTURE_UNOPTIMIZED _unoptimized)
  endif()
endmacro()

# Headers that nearly all sources include. A unit takes one to three seconds to read them, or a tenth of a
# second if they are precompiled.
set(FRACTURE_COMMON_HEADERS <algorithm> <array> <atomic> <bit> <chrono> <cmath> <compare> <concepts> <cstdint> <functional> <map>
    <memory> <mutex> <optional> <span> <stdexcept> <string> <string_view> <tuple> <type_traits> <unordered_map> <utility> <variant>
    <vector> <nlohmann/json.hpp> <tl/expected.hpp>)

# fracture_precompiled(target name options header...): in a unity build with g++, the target reads these
# headers precompiled. Targets with the same name share them. So they must have the same options, and must all
# be libraries or all be programs. clang reads headers faster, and it checks precompiled headers by their
# time, which a compiler cache does not preserve.
function(fracture_precompiled target name options)
  if(NOT FRACTURE_UNITY OR NOT CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    return()
  endif()
  set(shared fracture_precompiled_${name}${FRACTURE_UNOPTIMIZED})
  if(NOT TARGET ${shared})
    set(source ${CMAKE_BINARY_DIR}/precompiled/${shared}.cpp)
    file(CONFIGURE OUTPUT ${source} CONTENT "// Compiled for its headers.\n")
    add_library(${shared} OBJECT ${source})
    get_target_property(kind ${target} TYPE)
    if(kind STREQUAL EXECUTABLE)
      set_target_properties(${shared} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
      target_compile_options(${shared} PRIVATE -fPIE)
      target_link_libraries(${shared} PRIVATE GTest::gmock_main)
    endif()
    target_compile_options(${shared} PRIVATE ${options})
    target_link_libraries(${shared} PRIVATE fracture_strict_fp fracture_sanitizers fracture_warnings)
    target_precompile_headers(${shared} PRIVATE ${ARGN})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${shared})
endfunction()

# RARELY_RUN: code that runs once per command, start or page. It is compiled with less optimization, because
# each first build waits for it.
set(FRACTURE_RARELY_RUN -O1)

# fracture_library(name [RARELY_RUN] SOURCES ... DEPS ...): one module of the pipeline, also available as
# fracture::name. It is static but position-independent. In such code, g++ does not inline functions that
# another binary could replace. -fno-semantic-interposition allows inlining, because nothing here replaces
# functions.
function(fracture_library name)
  cmake_parse_arguments(ARG "RARELY_RUN" "" "SOURCES;DEPS" ${ARGN})
  add_library(fracture_${name} STATIC ${ARG_SOURCES})
  add_library(fracture::${name} ALIAS fracture_${name})
  set_target_properties(fracture_${name} PROPERTIES UNITY_BUILD ${FRACTURE_UNITY} UNITY_BUILD_BATCH_SIZE 0)
  target_include_directories(fracture_${name} PUBLIC ${CMAKE_SOURCE_DIR})
  set(options -fno-semantic-interposition)
  set(precompiled library)
  if(ARG_RARELY_RUN)
    list(APPEND options $<$<CONFIG:Release>:${FRACTURE_RARELY_RUN}>)
    set(precompiled rarely_run)
  endif()
  target_compile_options(fracture_${name} PRIVATE ${options})
  target_link_libraries(fracture_${name} PUBLIC ${ARG_DEPS} fracture_strict_fp fracture_sanitizers
                        PRIVATE fracture_warnings)
  fracture_precompiled(fracture_${name} ${precompiled} "${options}" ${FRACTURE_COMMON_HEADERS})
endfunction()

# Tests call fast code but need not be fast themselves: -O2 takes half as long again to compile. A folder may
# request less.
set(FRACTURE_TEST_OPTIMIZATION -O1)

# fracture_test(name LABELS unit|property|golden|e2e|threads|fuzz SOURCES ... DEPS ... [PRECOMPILE
# header...] [SECONDS n]): a GoogleTest program. PRECOMPILE: headers, relative to the root of the checkout,
# that nearly all of its sources include and that take longer to read than the tests themselves. SECONDS: how
# long a slow program takes. ctest starts the slowest first, so that none runs alone at the end.
function(fracture_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT;SECONDS" "SOURCES;DEPS;LABELS;PRECOMPILE" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 600)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${FRACTURE_UNITY} UNITY_BUILD_BATCH_SIZE 0)
  set(options $<$<CONFIG:Release>:${FRACTURE_TEST_OPTIMIZATION}>)
  target_compile_options(${name} PRIVATE ${options})
  if(ARG_PRECOMPILE AND NOT FRACTURE_UNITY)
    list(TRANSFORM ARG_PRECOMPILE PREPEND ${CMAKE_SOURCE_DIR}/)
    target_precompile_headers(${name} PRIVATE <gtest/gtest.h> ${ARG_PRECOMPILE})
  endif()
  fracture_precompiled(${name} test${FRACTURE_TEST_OPTIMIZATION} "${options}" ${FRACTURE_COMMON_HEADERS} <gtest/gtest.h>)
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_DEPS} fracture_warnings fracture_strict_fp fracture_sanitizers
                        GTest::gmock_main)
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT})
  if(ARG_SECONDS)
    set_tests_properties(${name} PROPERTIES COST ${ARG_SECONDS})
  endif()
  # `--target tests_threads`: the programs with this label and their dependencies, for builds that run no
  # other tests.
  foreach(label IN LISTS ARG_LABELS)
    if(NOT TARGET tests_${label})
      add_custom_target(tests_${label})
    endif()
    add_dependencies(tests_${label} ${name})
  endforeach()
endfunction()
