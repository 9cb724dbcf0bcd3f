# find_package(fracture): provides fracture_add_baked_asset() and finds the program that it runs.
include(${CMAKE_CURRENT_LIST_DIR}/FractureBake.cmake)
if(NOT FRACTURE_SERVER_PROGRAM)
  set(fracture_FOUND FALSE)
  set(fracture_NOT_FOUND_MESSAGE "fracture-server is not installed beside this file nor in PATH (FRACTURE_SERVER_PROGRAM)")
endif()
