#include "tests/tools/page.hpp"

#include <gtest/gtest.h>

namespace truepose::report {

pugi::xml_document parsed(const std::string& html) {
  pugi::xml_document page;
  const pugi::xml_parse_result result = page.load_string(html.c_str());
  EXPECT_TRUE(result) << result.description() << " at "
                      << html.substr(static_cast<std::size_t>(result.offset), 80);
  return page;
}

std::string text_of(const pugi::xml_node& node) {
  std::string text;
  for (const pugi::xpath_node& part : node.select_nodes(".//text()")) text += part.node().value();
  return text;
}

}  // namespace truepose::report
