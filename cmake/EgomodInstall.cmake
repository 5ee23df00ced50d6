# SPDX-License-Identifier: Apache-2.0
# The CMake package: find_package(egomod) gives egomod::core, egomod::features, ... egomod::lcmtypes.
# Programs, headers, types, configuration and unit are installed where they are built.
include(CMakePackageConfigHelpers)
set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/egomod")

set_target_properties(egomod_lcmtypes PROPERTIES EXPORT_NAME lcmtypes)
install(TARGETS egomod_lcmtypes EXPORT egomodMessagesTargets COMPONENT dev)
foreach(export egomodAlgorithmsTargets egomodMessagesTargets egomodDaemonTargets)
  install(EXPORT ${export} NAMESPACE egomod:: DESTINATION ${package_dir} COMPONENT dev)
endforeach()

write_basic_package_version_file("${CMAKE_CURRENT_BINARY_DIR}/egomodConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES cmake/egomodConfig.cmake cmake/FindLCM.cmake
  "${CMAKE_CURRENT_BINARY_DIR}/egomodConfigVersion.cmake" DESTINATION ${package_dir}
  COMPONENT dev)
install(FILES README.md CONTRIBUTING.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT egomod)
