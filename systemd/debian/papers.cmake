# Run where a package is filled: its copyright, and the change log that Debian's policy wants.
set(folder $ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/share/doc/${CMAKE_INSTALL_COMPONENT})
file(READ ${CMAKE_CURRENT_LIST_DIR}/copyright copyright)
if(CMAKE_INSTALL_COMPONENT STREQUAL "truepose-opcua")
  execute_process(COMMAND ${CMAKE_CURRENT_LIST_DIR}/node-copyright ${CMAKE_CURRENT_LIST_DIR}/../../build/opcua
    OUTPUT_VARIABLE of_node COMMAND_ERROR_IS_FATAL ANY)
endif()
file(WRITE ${folder}/copyright "${copyright}${of_node}")

string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # of SOURCE_DATE_EPOCH
file(WRITE ${folder}/changelog "truepose (${CPACK_PACKAGE_VERSION}) stable; urgency=medium

  * What has changed: CHANGELOG.md of the package truepose-doc.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")
execute_process(COMMAND gzip -9nf ${folder}/changelog COMMAND_ERROR_IS_FATAL ANY)
