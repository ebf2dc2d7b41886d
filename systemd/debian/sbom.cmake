# Run by CPack after the packages are written.
list(FILTER CPACK_PACKAGE_FILES INCLUDE REGEX "[.]deb$")
execute_process(COMMAND ${CMAKE_CURRENT_LIST_DIR}/sbom --node ${CMAKE_CURRENT_LIST_DIR}/../../build/opcua ${CPACK_PACKAGE_FILES}
  COMMAND_ERROR_IS_FATAL ANY)
