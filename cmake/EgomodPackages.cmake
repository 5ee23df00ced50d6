# SPDX-License-Identifier: Apache-2.0
# `cpack` in a build tree makes Debian packages: egomod (daemon and tools, unit, configuration), egomod-dev (headers,
# static libraries, CMake package, message types) and, where it is built, egomod-sim (the built-in world).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME egomod)
set(CPACK_PACKAGE_CONTACT "egomod developers <egomod@localhost>")
# Files that name their own place, such as the unit, are made during installation: for /usr, and staged elsewhere.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)

set(CPACK_COMPONENTS_ALL egomod dev)
if(TARGET egomod-sim)
  list(APPEND CPACK_COMPONENTS_ALL sim)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)

set(CPACK_DEBIAN_EGOMOD_PACKAGE_NAME egomod)
set(CPACK_DEBIAN_EGOMOD_PACKAGE_SECTION science)
set(CPACK_COMPONENT_EGOMOD_DESCRIPTION "The daemon, its tools, its configuration and its unit")
# egomod-eval draws with gnuplot; egomod-spy is Java.
set(CPACK_DEBIAN_EGOMOD_PACKAGE_RECOMMENDS "gnuplot-nox")
set(CPACK_DEBIAN_EGOMOD_PACKAGE_SUGGESTS "egomod-sim, default-jre, liblcm-java, libjchart2d-java")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME egomod-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
# What cmake/egomodConfig.cmake finds, and what the static libraries link.
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "liblcm-dev, liblcm-bin, libeigen3-dev, libboost-dev, libpng-dev, \
libjpeg62-turbo-dev, libturbojpeg0-dev, libspdlog-dev, libfmt-dev, libtomlplusplus-dev, libcli11-dev, \
libyaml-cpp-dev, libsystemd-dev, pkg-config")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Libraries, CMake package and LCM message types of egomod")

set(CPACK_DEBIAN_SIM_PACKAGE_NAME egomod-sim)
set(CPACK_DEBIAN_SIM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_SIM_PACKAGE_DEPENDS "libegl1, libegl-mesa0, libgl1-mesa-dri")  # loaded at run time
set(CPACK_DEBIAN_SIM_PACKAGE_ENHANCES egomod)
set(CPACK_COMPONENT_SIM_DESCRIPTION "The built-in world of egomod: renders what a stereo rig sees, with exact truth")

include(CPack)
