# Run by CPack when the packages are written, before it moves them to their folder.
list(FILTER CPACK_PACKAGE_FILES INCLUDE REGEX "[.]deb$")
execute_process(COMMAND ${CMAKE_CURRENT_LIST_DIR}/sbom --node ${CMAKE_CURRENT_LIST_DIR}/../../build/opcua
  --out ${CPACK_PACKAGE_DIRECTORY} ${CPACK_PACKAGE_FILES}
  COMMAND_ERROR_IS_FATAL ANY)
