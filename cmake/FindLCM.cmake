# SPDX-License-Identifier: Apache-2.0
# LCM 1.3.1 of Debian 12 ships no CMake package, and its pkg-config file wants glib's headers; 1.4 and later ship one.
# Defines lcm::lcm, LCM_GEN_EXECUTABLE, LCM_JAVA_JAR (optional).
find_package(lcm CONFIG QUIET)
find_path(LCM_INCLUDE_DIR lcm/lcm-cpp.hpp)
find_library(LCM_LIBRARY lcm)
find_program(LCM_GEN_EXECUTABLE lcm-gen)
find_file(LCM_JAVA_JAR lcm.jar PATHS /usr/share/java /usr/local/share/java)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(LCM REQUIRED_VARS LCM_LIBRARY LCM_INCLUDE_DIR LCM_GEN_EXECUTABLE
  REASON_FAILURE_MESSAGE "Debian 12: apt-get install liblcm-dev liblcm-bin")
if(LCM_FOUND AND NOT TARGET lcm::lcm)
  add_library(lcm::lcm UNKNOWN IMPORTED)
  set_target_properties(lcm::lcm PROPERTIES IMPORTED_LOCATION "${LCM_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${LCM_INCLUDE_DIR}")
endif()
mark_as_advanced(LCM_INCLUDE_DIR LCM_LIBRARY LCM_GEN_EXECUTABLE LCM_JAVA_JAR)
