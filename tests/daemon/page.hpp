#pragma once

#include <map>
#include <pugixml.hpp>
#include <string>
#include <string_view>

namespace truepose::report {

/// A page, which must be well-formed.
pugi::xml_document parsed(const std::string& html);

/// All text of a node and of those in it.
std::string text_of(const pugi::xml_node& node);

std::string base64_decoded(std::string_view text);
/// The files that a page carries for download, by their names.
std::map<std::string, std::string> downloads_of(const std::string& html);

}  // namespace truepose::report
