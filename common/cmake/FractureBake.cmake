# Breaks a game's meshes during its build. A mesh is baked again only if the mesh, a file that it refers to
# (buffers, textures, material libraries), its parameters or fracture-server changed. For Ninja and Makefiles.
#
#   find_package(fracture REQUIRED)
#   fracture_add_baked_asset(TARGET game INPUT assets/barrel.glb OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/barrel.glb
#                            PARAMETERS sites=80 material=wood)
#
# TARGET      depends on the output; created (as part of `all`) if it does not exist. May have many assets.
# INPUT       relative to the source folder.
# OUTPUT      relative to the binary folder. Extension .gltf: JSON; .glb or none: GLB; .obj (with .mtl and textures next to it),
#             .ply and .stl: only geometry and appearance. Default: the name of the input with .glb.
# PARAMETERS  name=value each, as listed by `fracture-server bake --help` (with - or _); write a semicolon in a value as \; .
# SERVER      http://host:port: bakes with a farm, with the same bytes. Its token is FRACTURE_TOKEN in the environment.
# THREADS     for one bake. Default: 1, because builds run many bakes at once. Does not affect the bytes.
#
# The target's property FRACTURE_BAKED_ASSETS lists its outputs. If a mesh is refused, the build fails with the reason.
# FRACTURE_SERVER_PROGRAM is the program. Default: the one installed with this file, otherwise the one in PATH.

find_program(FRACTURE_SERVER_PROGRAM fracture-server HINTS ${CMAKE_CURRENT_LIST_DIR}/../../../bin)

function(fracture_add_baked_asset)
  cmake_parse_arguments(PARSE_ARGV 0 ARG "" "TARGET;INPUT;OUTPUT;SERVER;THREADS" "PARAMETERS")
  set(where "fracture_add_baked_asset(INPUT ${ARG_INPUT})")
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "${where}: '${ARG_UNPARSED_ARGUMENTS}' is not an argument of this function")
  endif()
  if(NOT ARG_TARGET OR NOT ARG_INPUT)
    message(FATAL_ERROR "${where}: TARGET and INPUT are required")
  endif()
  if(NOT FRACTURE_SERVER_PROGRAM)
    message(FATAL_ERROR "${where}: fracture-server was not found; give -DFRACTURE_SERVER_PROGRAM=/path/to/fracture-server")
  endif()
  cmake_path(ABSOLUTE_PATH ARG_INPUT BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE OUTPUT_VARIABLE input)
  cmake_path(GET input FILENAME name)
  if(NOT ARG_OUTPUT)
    set(ARG_OUTPUT ${name}.glb)
  endif()
  cmake_path(ABSOLUTE_PATH ARG_OUTPUT BASE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR} NORMALIZE OUTPUT_VARIABLE output)
  cmake_path(GET output EXTENSION LAST_ONLY ending)
  string(TOLOWER "${ending}" ending)
  if(ending AND NOT ending MATCHES "^\\.(glb|gltf|obj|ply|stl)$")
    message(FATAL_ERROR "${where}: OUTPUT ends in '${ending}', which bake does not write; use .glb, .gltf, .obj, .ply or .stl")
  endif()
  set(byproducts)
  if(ending STREQUAL ".obj")
    cmake_path(REPLACE_EXTENSION output LAST_ONLY mtl OUTPUT_VARIABLE materials)
    set(byproducts BYPRODUCTS ${materials})
  endif()
  if(NOT ARG_THREADS)
    set(ARG_THREADS 1)
  endif()
  set(flags --quiet --threads ${ARG_THREADS})
  if(ARG_SERVER)
    list(APPEND flags --server ${ARG_SERVER})
  endif()
  foreach(parameter IN LISTS ARG_PARAMETERS)
    if(NOT parameter MATCHES "^[a-z_-]+=")
      message(FATAL_ERROR "${where}: '${parameter}' must be a parameter with a value, such as sites=80")
    endif()
    string(REPLACE "\\;" ";" parameter "${parameter}")
    string(REPLACE ";" "\\;" parameter "${parameter}")
    list(APPEND flags "--${parameter}")
  endforeach()
  add_custom_command(
    OUTPUT ${output}
    ${byproducts}
    COMMAND ${FRACTURE_SERVER_PROGRAM} bake ${input} --output ${output} --depfile ${output}.d ${flags}
    DEPENDS ${input} ${FRACTURE_SERVER_PROGRAM}
    DEPFILE ${output}.d
    COMMENT "Breaking ${name}"
    VERBATIM)
  string(MD5 digest ${output})
  string(SUBSTRING ${digest} 0 8 digest)
  string(MAKE_C_IDENTIFIER ${name} identifier)
  set(asset ${ARG_TARGET}-${identifier}-${digest})
  add_custom_target(${asset} DEPENDS ${output})
  if(NOT TARGET ${ARG_TARGET})
    add_custom_target(${ARG_TARGET} ALL)
  endif()
  add_dependencies(${ARG_TARGET} ${asset})
  set_property(TARGET ${ARG_TARGET} APPEND PROPERTY FRACTURE_BAKED_ASSETS ${output})
endfunction()
