#include "config/yaml_text.hpp"

#include "config/number_text.hpp"

namespace truepose::config {

std::string quoted_text(std::string_view text) {
  constexpr char kHex[] = "0123456789abcdef";
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') result += '\\';
    if (byte < 0x20) {
      result += std::string("\\x") + kHex[byte >> 4U] + kHex[byte & 15U];
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string xyz_text(const Eigen::Vector3d& v) {
  return "x: " + format_number(v.x()) + ", y: " + format_number(v.y()) + ", z: " + format_number(v.z());
}

}  // namespace truepose::config
