#include "tests/report_schema.hpp"

#include <gtest/gtest.h>

#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {

std::string report_schema_errors(const std::vector<std::filesystem::path>& documents) {
  const std::string source = TRUEPOSE_SOURCE_DIR;
  std::vector<std::string> arguments{source + "/tests/check_schema.py",
                                     source + "/proto/control/report.schema.json"};
  arguments.insert(arguments.end(), documents.begin(), documents.end());
  // Debian's own interpreter, which has Debian's jsonschema.
  const TempFolder folder;
  Process check{folder.path(), "/usr/bin/python3", arguments};
  const int exit_code = check.wait();
  EXPECT_EQ(exit_code == 0, check.errors().empty());
  return check.errors();
}

}  // namespace truepose
