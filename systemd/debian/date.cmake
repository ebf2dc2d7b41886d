# Read by CPack. The date of all files is that of the sources' last commit, so two packages of one commit are equal.
if(NOT DEFINED ENV{SOURCE_DATE_EPOCH})
  execute_process(COMMAND git -C ${CMAKE_CURRENT_LIST_DIR} log -1 --format=%ct
    OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT date)
    file(TIMESTAMP ${CMAKE_CURRENT_LIST_DIR}/../../CHANGELOG.md date %s UTC)  # of an archive without git
  endif()
  set(ENV{SOURCE_DATE_EPOCH} ${date})
endif()
