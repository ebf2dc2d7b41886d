#pragma once

#include <pugixml.hpp>
#include <string>

namespace truepose::report {

/// A page, which must be well-formed.
pugi::xml_document parsed(const std::string& html);

/// All text of a node and of those in it.
std::string text_of(const pugi::xml_node& node);

}  // namespace truepose::report
