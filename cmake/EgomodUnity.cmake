# SPDX-License-Identifier: Apache-2.0
# The sanitizers' presets and clang-tidy compile several files of a target as one (CMAKE_UNITY_BUILD), which spares
# reading the same headers again and again. Not these targets: their files use one name for different things.
foreach(target egomod_features egomod_moving_objects egomod_eval egomod_sim
    image_primitives_test feature_tracker_test eval_test)
  if(TARGET ${target})
    set_target_properties(${target} PROPERTIES UNITY_BUILD OFF)
  endif()
endforeach()
