#include "tests/daemon/page.hpp"

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

std::string base64_decoded(std::string_view text) {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned group = 0;
  int bits = 0;
  for (const char digit : text) {
    if (digit == '=') break;
    group = group << 6 | static_cast<unsigned>(kDigits.find(digit));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(group >> bits & 0xff);
  }
  return bytes;
}

std::map<std::string, std::string> downloads_of(const std::string& html) {
  std::map<std::string, std::string> files;
  const pugi::xml_document page = parsed(html);
  for (const pugi::xpath_node& link : page.select_nodes("//a[@download]")) {
    const std::string data = link.node().attribute("href").value();
    files[link.node().attribute("download").value()] = base64_decoded(data.substr(data.find(',') + 1));
  }
  return files;
}

}  // namespace truepose::report
