# SPDX-License-Identifier: Apache-2.0

function(egomod_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow
    -Wnon-virtual-dtor -Wold-style-cast)
  if(EGOMOD_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
endfunction()

# What find_package(egomod) can be asked for by name: three exports, each with what it needs. See egomodConfig.cmake.
set(egomod_algorithms core features egomotion moving_objects)
set(egomod_messages lcmtypes bus)
function(egomod_export_of name result)
  if(name IN_LIST egomod_algorithms)
    set(${result} egomodAlgorithmsTargets PARENT_SCOPE)
  elseif(name IN_LIST egomod_messages)
    set(${result} egomodMessagesTargets PARENT_SCOPE)
  else()
    set(${result} egomodDaemonTargets PARENT_SCOPE)
  endif()
endfunction()

# egomod_library(NAME folder SOURCES a.cpp ... LINK public... LINK_PRIVATE private...)
# A library egomod_<folder> whose headers are include/egomod/<folder>/*.hpp, each proven to compile alone
# by the target all_verify_interface_header_sets.
function(egomod_library)
  cmake_parse_arguments(arg "" "NAME" "SOURCES;LINK;LINK_PRIVATE" ${ARGN})
  set(target egomod_${arg_NAME})
  file(GLOB headers CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/include/egomod/${arg_NAME}/*.hpp")
  add_library(${target} STATIC ${arg_SOURCES})
  add_library(egomod::${arg_NAME} ALIAS ${target})
  target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS "${PROJECT_SOURCE_DIR}/include"
    FILES ${headers})
  set_target_properties(${target} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON EXPORT_NAME ${arg_NAME})
  target_link_libraries(${target} PUBLIC ${arg_LINK} PRIVATE ${arg_LINK_PRIVATE})
  egomod_warnings(${target})
  egomod_export_of(${arg_NAME} export)
  install(TARGETS ${target} EXPORT ${export}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
    FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev)
endfunction()

# egomod_program(NAME name SOURCES ... LINK ... [COMPONENT package]): part of the package egomod unless said otherwise
function(egomod_program)
  cmake_parse_arguments(arg "" "NAME;COMPONENT" "SOURCES;LINK" ${ARGN})
  if(NOT arg_COMPONENT)
    set(arg_COMPONENT egomod)
  endif()
  add_executable(${arg_NAME} ${arg_SOURCES})
  target_link_libraries(${arg_NAME} PRIVATE ${arg_LINK})
  egomod_warnings(${arg_NAME})
  install(TARGETS ${arg_NAME} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR}
    COMPONENT ${arg_COMPONENT})
endfunction()

# All tests and what they run, and nothing else.
add_custom_target(egomod_tests)

# egomod_test(NAME name SOURCES ... LINK ... [TIMEOUT s] [LABELS slow]): one GoogleTest program, one
# ctest entry a test case. What is labelled slow does not run under the sanitizers.
function(egomod_test)
  cmake_parse_arguments(arg "" "NAME;TIMEOUT" "SOURCES;LINK;LABELS" ${ARGN})
  add_executable(${arg_NAME} ${arg_SOURCES})
  set_target_properties(${arg_NAME} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/tests")
  target_link_libraries(${arg_NAME} PRIVATE ${arg_LINK} GTest::gtest_main GTest::gmock)
  egomod_warnings(${arg_NAME})
  add_dependencies(egomod_tests ${arg_NAME})
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 120)
  endif()
  if(EGOMOD_SANITIZE)  # instrumented code runs up to twenty times slower
    math(EXPR arg_TIMEOUT "5 * ${arg_TIMEOUT}")
  endif()
  set(properties TIMEOUT ${arg_TIMEOUT})
  if(arg_LABELS)
    list(APPEND properties LABELS "${arg_LABELS}")
  endif()
  if(EGOMOD_SANITIZE MATCHES "thread")
    list(APPEND properties
      ENVIRONMENT "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/thread_sanitizer.supp")
  endif()
  gtest_discover_tests(${arg_NAME} DISCOVERY_MODE PRE_TEST PROPERTIES ${properties})
endfunction()
