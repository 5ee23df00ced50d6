# SPDX-License-Identifier: Apache-2.0
# The Java sources are named by package, so they are known only after lcm-gen ran.
file(REMOVE_RECURSE "${WORK_DIR}")
file(MAKE_DIRECTORY "${WORK_DIR}/source" "${WORK_DIR}/classes")
get_filename_component(output_dir "${OUTPUT}" DIRECTORY)
file(MAKE_DIRECTORY "${output_dir}")

execute_process(COMMAND "${LCM_GEN}" -j --jpath "${WORK_DIR}/source" ${LCM_FILES}
  COMMAND_ERROR_IS_FATAL ANY)
file(GLOB_RECURSE sources "${WORK_DIR}/source/*.java")
execute_process(COMMAND "${JAVAC}" -nowarn -cp "${LCM_JAR}" -d "${WORK_DIR}/classes" ${sources}
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${JAR}" cf "${OUTPUT}" -C "${WORK_DIR}/classes" .
  COMMAND_ERROR_IS_FATAL ANY)
