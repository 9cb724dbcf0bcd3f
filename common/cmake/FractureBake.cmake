# Breaks the meshes of a game when the game is built: each again only when the mesh, a file that it names (buffers,
# textures, material libraries), its parameters or fracture-server changed. For Ninja and Makefiles.
#
#   find_package(fracture REQUIRED)
#   fracture_add_baked_asset(TARGET game INPUT assets/barrel.glb OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/barrel.glb
#                            PARAMETERS sites=80 material=wood)
#
# TARGET      depends on the output; made (as one of `all`) where there is no such target. May have any number of assets.
# INPUT       relative to the source folder.
# OUTPUT      relative to the binary folder; a name that ends in .gltf is JSON, one in .glb or without an ending GLB; .obj (with
#             .mtl and textures beside it), .ply and .stl are geometry and looks alone. Default: the name of the input and .glb.
# PARAMETERS  name=value each, as `fracture-server bake --help` lists them (with - or _); a semicolon in a value as \; .
# SERVER      http://host:port: through a farm, to the same bytes. FRACTURE_TOKEN of the build's environment is its token.
# THREADS     of one bake, 1 where it is not given: builds run many at a time. The bytes do not depend on it.
#
# The outputs of a target stand in its property FRACTURE_BAKED_ASSETS. A mesh that is refused fails the build with the
# reason. FRACTURE_SERVER_PROGRAM is the program: the one that is installed with this file, else from PATH.

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
