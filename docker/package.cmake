# `cmake --install BUILD --component server` installs the programs, their systemd unit and the licence under a prefix. `cpack` in
# the build folder makes a Debian package of the same files, for machines without containers and for the image itself. Its
# dependencies are read from the programs (dpkg-shlibdeps), so that the list cannot become outdated.
include(GNUInstallDirs)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/systemd/fracture-server.service DESTINATION lib/systemd/system COMPONENT server)
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/fracture-server RENAME copyright
        COMPONENT server)

# Both use the existing build (--target fracture-server) and build nothing themselves. The package does not contain the client.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)
set(CPACK_INSTALL_CMAKE_PROJECTS "${CMAKE_BINARY_DIR};fracture;server;/")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME fracture-server)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_CONTACT "The fracture developers <fracture@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION net)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_LIST_DIR}/systemd/prerm)
include(CPack)
