# SPDX-License-Identifier: Apache-2.0
# OpenCV's CMake package lives in the metapackage that pulls in everything; the split packages are found by hand.
# egomod_find_opencv(module) makes egomod::opencv_<module>, warnings of its headers silenced.
function(egomod_find_opencv module)
  if(TARGET egomod::opencv_${module})
    return()
  endif()
  find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
  find_library(OPENCV_${module}_LIBRARY opencv_${module} REQUIRED)
  add_library(egomod::opencv_${module} INTERFACE IMPORTED)
  target_include_directories(egomod::opencv_${module} SYSTEM INTERFACE "${OPENCV_INCLUDE_DIR}")
  target_link_libraries(egomod::opencv_${module} INTERFACE "${OPENCV_${module}_LIBRARY}")
endfunction()
