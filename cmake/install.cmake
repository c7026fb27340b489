# Install and export: the library with its headers, the binary, and a package for find_package(remaps).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

target_compile_features(remaps PUBLIC cxx_std_20)

# The flags are exported because a static library names what it was linked with; as a private
# dependency they pass no compile option on.
install(TARGETS remaps remaps_flags EXPORT remapsTargets)
install(TARGETS remaps_cli)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/remaps DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.h")

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/remaps)
install(EXPORT remapsTargets NAMESPACE remaps:: DESTINATION ${package_dir})
configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/remapsConfig.cmake.in ${PROJECT_BINARY_DIR}/remapsConfig.cmake
  INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/remapsConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/remapsConfig.cmake
              ${PROJECT_BINARY_DIR}/remapsConfigVersion.cmake DESTINATION ${package_dir})
