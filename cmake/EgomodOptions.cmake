# SPDX-License-Identifier: Apache-2.0
set(EGOMOD_BUILD_TESTS AUTO CACHE STRING
  "Build tests and benchmarks: ON, OFF, or AUTO: where GoogleTest, Google Benchmark and OpenCV's modules for them are found")
set_property(CACHE EGOMOD_BUILD_TESTS PROPERTY STRINGS AUTO ON OFF)
option(EGOMOD_WARNINGS_AS_ERRORS "Treat compiler warnings as errors" OFF)
set(EGOMOD_SANITIZE "" CACHE STRING "Sanitizers, as -fsanitize= takes them: address,undefined or thread")

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Debug, Release or RelWithDebInfo" FORCE)
endif()

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

# Programs find their presets and the jar relative to themselves: the build tree looks like an installed one.
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
set(EGOMOD_DATA_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/${CMAKE_INSTALL_DATADIR}/egomod")

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CCACHE_PROGRAM}")
endif()

if(EGOMOD_SANITIZE)
  # To check each access for null and alignment would take a third of the time to build: null faults by itself.
  add_compile_options(-fsanitize=${EGOMOD_SANITIZE} -fno-sanitize=null,alignment -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${EGOMOD_SANITIZE})
endif()

# Binaries run on any x86-64-v2 or arm64; wider vectors are chosen at run time.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  add_compile_options(-march=x86-64-v2)
endif()
